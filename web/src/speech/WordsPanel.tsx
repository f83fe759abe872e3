/** What words the robot listens for, and what it heard last. */

import { rich, t } from "../i18n";
import { panel } from "../panels/panel";
import { type App, useApp } from "../state/context";
import type { Message } from "../state/latest";
import { SoundIcon } from "../ui/icons";
import { heardDetails, heardText, listening } from "./heard";

export const wordsPanel = panel({
  type: "heard_words",
  tab: "Found",
  Card: Words,
  offered: (app) => listeningNow(app) !== null || app.store.of("heard_words").value !== null,
});

function listeningNow({ store }: App) {
  return listening(store.of("desires").value, store.of("intention").value, store.rows.value);
}

function Words({ message: heard }: { message: Message<"heard_words"> | null }) {
  const app = useApp();
  const now = listeningNow(app);
  return (
    <section class="card" aria-label={t("Words")} data-testid="words">
      <h2>{t("Words")}</h2>
      {now ? (
        <p data-testid="listening">
          {rich("Listening for {words}", { words: <b lang={now.language}>{now.words.join(", ")}</b> })}
        </p>
      ) : (
        <p class="empty">{t("No words are listened for.")}</p>
      )}
      {now?.reason && <p class="muted small">{now.reason}</p>}
      {heard && (
        <ul class="percepts">
          <li class={`percept ${heard.unsure ? "past" : ""}`} data-testid="heard" data-unsure={heard.unsure}>
            <span class="percept-icon voice">
              <SoundIcon />
            </span>
            <b lang={heard.language}>{heardText(heard)}</b>
            <span>{heardDetails(heard, app.store.seconds.value)}</span>
          </li>
        </ul>
      )}
    </section>
  );
}
