/** Steers the tour that is led: by its buttons, by what visitors say, to another stop, to its end. */

import { useSignal } from "@preact/signals";
import { t } from "../i18n";
import { Confirm } from "../map/Confirm";
import type { TourProgress } from "../protocol/types";
import { useApp } from "../state/context";
import { PauseIcon, PlayIcon } from "../ui/icons";
import { textOf } from "./tourEdits";
import { type Control, controlsOf, visitorControls } from "./tourRunText";

export function TourSteering({ progress }: { progress: TourProgress }) {
  const { store, tourRun } = useApp();
  const ending = useSignal(false);
  const asks = visitorControls(progress);
  const controls = controlsOf(progress, store.stopped.value);
  const [main, others] = [controls.filter(isMain), controls.filter((control) => !isMain(control))];
  const press = ({ button }: Control) => {
    if (button === "end") ending.value = true;
    else void tourRun.press({ button });
  };
  return (
    <>
      {main.length > 0 && (
        <div class="tour-run-buttons">
          {main.map((control) => (
            <RunButton key={control.button} control={control} onPress={press} />
          ))}
        </div>
      )}
      {asks.length + progress.questions.length > 0 && (
        <div class="tour-run-buttons for-visitors" role="group" aria-label={t("Said for visitors")}>
          <span class="muted small">{t("Press what visitors say")}</span>
          {asks.map((control) => (
            <RunButton key={control.button} control={control} onPress={press} />
          ))}
          {progress.questions.map(({ id, question }) => (
            <button
              key={id}
              type="button"
              class="button quiet wide"
              data-testid="tour-run-ask"
              data-question={id}
              disabled={!tourRun.allowed.value}
              onClick={() => void tourRun.press({ ask: id })}
            >
              {textOf(question, progress.languages)}
            </button>
          ))}
        </div>
      )}
      <div class="tour-run-buttons" role="group" aria-label={t("Steer the tour")}>
        {others.map((control) => (
          <RunButton key={control.button} control={control} onPress={press} />
        ))}
        {progress.waits && progress.state === "idle" && (
          <button
            type="button"
            class="button"
            data-testid="tour-run-dismiss"
            disabled={!tourRun.allowed.value}
            onClick={() => void tourRun.dismiss()}
          >
            {t("Stop waiting")}
          </button>
        )}
      </div>
      {ending.value && progress.state !== "idle" && (
        <Confirm
          words={t("End the tour now? The robot says goodbye first.")}
          yes={t("End the tour")}
          no={t("Do not end it")}
          onYes={() => {
            ending.value = false;
            void tourRun.press({ button: "end" });
          }}
          onNo={() => (ending.value = false)}
        />
      )}
      <GoToStop progress={progress} />
    </>
  );
}

/** What holds the robot, or has it go on: large, and always first. */
function isMain({ button }: Control): boolean {
  return button === "resume" || button === "pause" || button === "start";
}

function RunButton({ control, onPress }: { control: Control; onPress: (control: Control) => void }) {
  const { tourRun } = useApp();
  const { button, words, works } = control;
  const main = isMain(control);
  return (
    <button
      type="button"
      class={`button ${main ? "main" : ""} ${button === "resume" || button === "start" ? "accent" : ""}`}
      data-testid={`tour-press-${button}`}
      disabled={!works || !tourRun.allowed.value}
      onClick={() => onPress(control)}
    >
      {button === "pause" && <PauseIcon />}
      {(button === "resume" || button === "start") && <PlayIcon />}
      {words}
    </button>
  );
}

function GoToStop({ progress }: { progress: TourProgress }) {
  const { tourRun } = useApp();
  const stops = tourRun.stops.value;
  if (!progress.buttons.includes("skip") || stops.length < 2) return null;
  return (
    <select
      class="tour-run-go"
      aria-label={t("Go to a stop")}
      data-testid="tour-run-go"
      value=""
      disabled={!tourRun.allowed.value}
      onChange={(event) => {
        const stop = event.currentTarget.value;
        event.currentTarget.value = "";
        if (stop) void tourRun.press({ stop });
      }}
    >
      <option value="">{t("Go to a stop…")}</option>
      {stops.map(({ id, title }, index) => (
        <option key={id} value={id}>
          {`${index + 1}  ${textOf(title, progress.languages) || id}`}
        </option>
      ))}
    </select>
  );
}
