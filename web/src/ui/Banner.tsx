/** Says over the view that what is shown is not the present, and what happens about it. */

import { rich, t } from "../i18n";
import { useApp } from "../state/context";
import { number } from "./format";
import { WarnIcon } from "./icons";

export function Banner() {
  const { store } = useApp();
  const { phase, retryAt } = store.link.value;
  void store.now.value; // counts down with the clock
  void store.viewAgeMs.value;
  if (phase === "live" || phase === "login") return null;
  const wait = Math.max(0, (retryAt - performance.now()) / 1000);
  const soon = wait > 0.5 ? t("Next attempt in {wait} s.", { wait: Math.ceil(wait) }) : t("Trying now…");
  const age = store.viewAgeMs.value;
  const replay = store.replay.value;
  const { drives } = store.body.value;
  return (
    <div class={`banner ${phase}`} role="alert" data-testid="banner" data-phase={phase}>
      {phase === "connecting" ? <span class="spinner" aria-hidden="true" /> : <WarnIcon />}
      {phase === "connecting" && (
        <p>
          <b>{t("Connecting to the robot…")}</b>
          {retryAt > 0 && (
            <span aria-hidden="true">
              {t("It does not answer yet.")} {soon}
            </span>
          )}
        </p>
      )}
      {phase === "stale" && replay && (
        <p>
          <b>{t("The replay does not answer.")}</b>
          <span>{t("The page continues when it answers.")}</span>
        </p>
      )}
      {phase === "stale" && !replay && (
        <p>
          <b>{t("The robot does not answer.")}</b>
          <span>
            {rich("The data on this page is {age} old.", {
              age: <span aria-hidden="true">{age === null ? "" : `${number(age / 1000, 1)} s`}</span>,
            })}
            {drives && ` ${t("You cannot drive; without commands the robot stops.")}`}
          </span>
        </p>
      )}
      {phase === "lost" && (
        <p>
          <b>
            {replay
              ? t("Connection to the replay lost. Reconnecting…")
              : [
                  t("Connection to the robot lost."),
                  drives && t("Without commands it stops by itself."),
                  t("Reconnecting…"),
                ]
                  .filter(Boolean)
                  .join(" ")}
          </b>
          <span aria-hidden="true">{soon}</span>
        </p>
      )}
    </div>
  );
}
