/** Speak through the robot: while this button, or the key V, is held. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { MicrophoneIcon } from "../ui/icons";
import { LevelBars } from "./LevelBars";

export function TalkButton() {
  const { store, talking } = useApp();
  const speaker = store.of("status").value?.speaker ?? null;
  const state = talking.state.value;
  const refusal = talking.refusal.value;
  const held = (event: KeyboardEvent) => event.code === "Space" || event.code === "Enter";
  return (
    <button
      type="button"
      class={`button small tool-button talk ${state}`}
      data-testid="talk"
      data-state={state}
      data-taken={speaker?.mine ?? false}
      data-level-db={talking.level.value?.toFixed(1) ?? ""}
      aria-pressed={state === "talking"}
      aria-disabled={refusal !== null}
      aria-label={t("Hold to speak through the robot")}
      title={refusal ?? t("Hold this or V and speak through the robot")}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        talking.press();
      }}
      onPointerUp={(event) => {
        talking.release();
        event.currentTarget.blur(); // the keys go on driving
      }}
      onPointerCancel={() => talking.release()}
      onLostPointerCapture={() => talking.release()}
      onKeyDown={(event) => {
        if (!held(event)) return;
        event.preventDefault();
        if (!event.repeat) talking.press();
      }}
      onKeyUp={(event) => held(event) && talking.release()}
      onBlur={() => talking.release()}
      onContextMenu={(event) => event.preventDefault()}
    >
      <MicrophoneIcon />
      {state === "talking" ? (
        <>
          <LevelBars level={talking.level.value} />
          <span class="tool-figure">{t("Speaking")}</span>
        </>
      ) : (
        <span class="tool-words">
          {state === "opening" ? (
            t("Opening…")
          ) : speaker && !speaker.mine ? (
            t("{operator} speaks", { operator: speaker.operator })
          ) : (
            <>
              <span class="only-wide">{t("Hold to speak")} </span>
              <span class="only-narrow">{t("Speak")}</span>
              <kbd class="only-wide">V</kbd>
            </>
          )}
        </span>
      )}
    </button>
  );
}
