/** The emergency stop, and its release: a deliberate second step. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { StopIcon } from "./icons";

const ASK_MS = 6000;

export function EStop() {
  const { store, session, drive } = useApp();
  const stopped = store.stopped.value;
  const asking = useSignal(false);
  useEffect(() => {
    if (!stopped) asking.value = false;
  }, [stopped]);
  useEffect(() => {
    if (!asking.value) return;
    const timer = window.setTimeout(() => (asking.value = false), ASK_MS);
    return () => clearTimeout(timer);
  }, [asking.value]);

  const stop = () => {
    drive.release(true);
    session.eStop();
  };
  return (
    <div class={`estop-group ${stopped ? "latched" : ""}`}>
      {stopped && !asking.value && (
        <button type="button" class="button release" data-testid="estop-release" onClick={() => (asking.value = true)}>
          {t("Release stop…")}
        </button>
      )}
      {stopped && asking.value && (
        <span class="estop-ask" role="group" aria-label={t("The robot may move again")}>
          <span class="estop-question">{t("It may move again.")}</span>
          <button
            type="button"
            class="button release"
            data-testid="estop-release-confirm"
            onClick={() => {
              asking.value = false;
              session.clearEStop();
            }}
          >
            {t("Release")}
          </button>
          <button
            type="button"
            class="button release quiet"
            data-testid="estop-keep"
            onClick={() => (asking.value = false)}
          >
            {t("Keep|the stop")}
          </button>
        </span>
      )}
      <button
        type="button"
        class="estop"
        data-testid="estop"
        aria-pressed={stopped}
        aria-keyshortcuts="Escape"
        onClick={stop}
      >
        <StopIcon />
        <span>{stopped ? t("STOPPED") : t("E-STOP")}</span>
      </button>
    </div>
  );
}
