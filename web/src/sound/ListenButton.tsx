/** Hear what the robot hears: one click on, one click off; how loud it is and how late. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { HeadphonesIcon } from "../ui/icons";
import { LevelBars } from "./LevelBars";

export function ListenButton() {
  const { listening } = useApp();
  const on = listening.on.value;
  const refusal = on ? null : listening.refusal.value;
  const silence = listening.silence.value;
  const latency = listening.latency.value;
  const ms = latency === null ? null : Math.round(latency * 100) * 10;
  return (
    <div class="view-tool">
      {silence && (
        <p class="tool-note" role="status" data-testid="listen-silence">
          {silence}
        </p>
      )}
      <button
        type="button"
        class={`button small tool-button ${on ? "on" : ""}`}
        data-testid="listen"
        data-latency-ms={latency === null ? "" : Math.round(latency * 1000)}
        data-level-db={listening.level.value?.toFixed(1) ?? ""}
        aria-pressed={on}
        aria-disabled={refusal !== null}
        aria-label={on ? t("Stop listening to the robot") : t("Listen to the robot")}
        title={refusal ?? (on ? t("Stop listening. The figure is the delay.") : t("Hear what the robot hears"))}
        onClick={(event) => {
          listening.toggle();
          if (event.detail > 0) event.currentTarget.blur(); // the keys go on driving
        }}
      >
        <HeadphonesIcon />
        {on ? (
          <>
            <LevelBars level={listening.level.value} />
            <span class="tool-figure">{ms === null ? "…" : t("{ms} ms", { ms })}</span>
          </>
        ) : (
          <span class="tool-words">{t("Listen")}</span>
        )}
      </button>
    </div>
  );
}
