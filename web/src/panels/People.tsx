/** Who is seen now and what is heard now: how far, and in which direction; and what else is noticed. */

import { directionWords, faceMarks, soundMarks } from "../around/perceptMarks";
import { whyClosed } from "../around/whyClosed";
import { decimals, t } from "../i18n";
import type { RobotEvent } from "../protocol/types";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { PersonIcon, SoundIcon } from "../ui/icons";
import { panel } from "./panel";

/** Kinds of percepts that are drawn by themselves; all others are listed. */
const DRAWN = new Set<unknown>(["face", "voice", "noise", "code"]);

/** Labels of the percepts that are there: of each subject of a kind, the newest event is not that it leaves. */
export function noticed(events: RobotEvent[]): string[] {
  const there = new Map<string, string>();
  for (const { kind, subject, data } of events) {
    if (kind !== "percept" || !data || DRAWN.has(data.kind)) continue;
    const key = `${data.kind} ${data.subject}`;
    if (subject?.endsWith(".leaves")) there.delete(key);
    else there.set(key, String(data.label));
  }
  return [...there.values()];
}

export const peoplePanel = panel({ type: "perceived", tab: "Found", Card: People, offered: () => true });

function People({ message: perceived }: { message: Message<"perceived"> | null }) {
  const { store } = useApp();
  const now = store.now.value ?? perceived?.stamp ?? 0;
  const faces = faceMarks(perceived).reverse();
  const sounds = soundMarks(perceived, now).reverse();
  const others = noticed(store.events.value);
  const closed = whyClosed(store.hello.value, store.rows.value, store.replay.value, true).filter(
    ({ what }) => what !== "picture",
  );
  return (
    <section class="card" aria-label={t("People and sounds")} data-testid="people">
      <h2>
        {t("People and sounds now")} <span class="count">{faces.length + sounds.length}</span>
      </h2>
      {faces.length + sounds.length === 0 && <p class="empty">{t("No people seen, no sounds heard.")}</p>}
      {faces.length + sounds.length > 0 && (
        <ul class="percepts">
          {faces.map((face) => (
            <li key={`face ${face.track}`} class="percept" data-testid="person" data-track={face.track}>
              <span class="percept-icon face">
                <PersonIcon />
              </span>
              <b>{t("Person {track}", { track: face.track })}</b>
              <span>{directionWords(face.azimuth)}</span>
              <span class="percept-range">{face.range === null ? "" : `${decimals(face.range.toFixed(1))} m`}</span>
            </li>
          ))}
          {sounds.map((sound) => (
            <li
              key={`sound ${sound.track}`}
              class={`percept ${sound.active ? "" : "past"}`}
              data-testid="sound"
              data-track={sound.track}
            >
              <span class={`percept-icon ${sound.kind}`}>
                <SoundIcon />
              </span>
              <b>{sound.kind === "voice" ? t("Voice") : t("Sound")}</b>
              <span>{directionWords(sound.azimuth)}</span>
              <span class="percept-range">{/, (.*)/.exec(sound.text)?.[1] ?? ""}</span>
            </li>
          ))}
        </ul>
      )}
      {others.length > 0 && (
        <p class="muted small" data-testid="noticed">
          {t("Noticed: {things}.", { things: others.join(", ") })}
        </p>
      )}
      {closed.map(({ what, text, reason }) => (
        <p key={what} class="muted small">
          {reason ? t("{what}: {which}", { what: text, which: reason }) : `${text}.`}
        </p>
      ))}
    </section>
  );
}
