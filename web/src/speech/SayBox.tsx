/** What the robot is to say, typed; its gestures and expressions, by a press. */

import { useSignal } from "@preact/signals";
import { named, t } from "../i18n";
import { inWords } from "../protocol/problem";
import { idempotencyKey } from "../protocol/requests";
import type { NewDesire } from "../protocol/types";
import { useApp } from "../state/context";
import { SpeechIcon } from "../ui/icons";
import { usePopup } from "../ui/usePopup";
import { acts, say } from "./acts";

export function SayButton() {
  const { session, store } = useApp();
  const { open, button, box } = usePopup("input");
  const text = useSignal("");
  const problem = useSignal("");
  const hello = store.hello.value;
  const offered = acts(hello?.classes ?? [], hello?.scale ?? { intensity: 8, utility: 8 });
  const speaks = hello?.classes.some(({ name, served }) => name === "Say" && served) ?? false;
  if (store.replay.value || (!speaks && offered.length === 0)) return null;

  const desire = async (wanted: NewDesire): Promise<boolean> => {
    problem.value = "";
    try {
      await session.rest.addDesire(wanted, idempotencyKey());
      return true;
    } catch (error) {
      problem.value = inWords(error);
      return false;
    }
  };
  return (
    <div class="say">
      <button
        type="button"
        ref={button}
        class={`button small tool-button ${open.value ? "on" : ""}`}
        aria-haspopup="dialog"
        aria-expanded={open.value}
        aria-label={t("Let the robot say something")}
        title={t("Type what the robot says; gestures and expressions")}
        data-testid="say"
        onClick={() => (open.value = !open.value)}
      >
        <SpeechIcon /> <span class="tool-words">{t("Say")}</span>
      </button>
      {open.value && (
        <div class="say-box" ref={box} role="dialog" aria-label={t("Say")} data-testid="say-box">
          {speaks && (
            <form
              onSubmit={(event) => {
                event.preventDefault();
                const typed = text.value.trim();
                if (typed === "") return;
                void desire(say(typed, hello!.scale)).then((done) => {
                  if (done) text.value = "";
                });
              }}
            >
              <input
                data-testid="say-text"
                aria-label={t("What the robot says")}
                placeholder={t("What the robot says")}
                autocomplete="off"
                maxLength={2000}
                value={text.value}
                onInput={(event) => (text.value = event.currentTarget.value)}
              />
              <button type="submit" class="button small accent" data-testid="say-send">
                {t("Say")}
              </button>
            </form>
          )}
          {offered.length > 0 && (
            <div class="say-acts">
              {offered.map((act) => (
                <button
                  key={act.title}
                  type="button"
                  class="kind"
                  data-testid={`act-${act.title.toLowerCase()}`}
                  onClick={() => void desire(act.desire)}
                >
                  {named(act.title)}
                </button>
              ))}
            </div>
          )}
          {problem.value && (
            <p class="inline-note error" role="alert">
              {problem.value}
            </p>
          )}
        </div>
      )}
    </div>
  );
}
