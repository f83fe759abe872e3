/** What happened: every event of the robot's timeline, newest first, by kind. */

import { useSignal } from "@preact/signals";
import { fromRobot, langOf, named, t } from "../i18n";
import { useApp } from "../state/context";
import { ago, clockTime } from "../ui/format";
import { panel } from "./panel";

const SHOWN = 200;

export const eventsPanel = panel({ type: "events", tab: "Events", Card: Events, offered: () => true });

function Events() {
  const { store } = useApp();
  const events = store.events.value;
  const off = useSignal<ReadonlySet<string>>(new Set());
  const kinds = [...new Set(events.map((event) => event.kind))].sort();
  const shown = events
    .filter((event) => !off.value.has(event.kind))
    .slice(-SHOWN)
    .reverse();
  const now = store.seconds.value;
  const toggle = (kind: string) => {
    const next = new Set(off.value);
    if (!next.delete(kind)) next.add(kind);
    off.value = next;
  };
  return (
    <section class="card" aria-label={t("Events")} data-testid="events">
      <h2>{t("Events")}</h2>
      {kinds.length > 1 && (
        <div class="kinds" role="group" aria-label={t("Kinds shown")}>
          {kinds.map((kind) => (
            <button
              key={kind}
              type="button"
              class="kind"
              aria-pressed={!off.value.has(kind)}
              data-kind={kind}
              onClick={() => toggle(kind)}
            >
              {named(kind.replace(/_/g, " "))}
            </button>
          ))}
        </div>
      )}
      {shown.length === 0 && (
        <p class="empty">
          {events.length > 0
            ? t("All kinds are turned off.")
            : store.eventsKnown.value
              ? t("No events yet.")
              : t("Reading the timeline…")}
        </p>
      )}
      <ol class="events">
        {shown.map((event) => (
          <li
            key={`${event.id}@${event.stamp}`}
            class="event"
            data-testid="event"
            data-kind={event.kind}
            data-subject={event.subject}
          >
            <time title={clockTime(event.stamp)}>{now === null ? clockTime(event.stamp) : ago(now - event.stamp)}</time>
            <span class="event-kind">{named(event.kind.replace(/_/g, " "))}</span>
            <p lang={langOf(event.text)}>{fromRobot(event.text)}</p>
          </li>
        ))}
      </ol>
    </section>
  );
}
