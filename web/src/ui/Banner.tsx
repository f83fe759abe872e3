/** Says over the view that what is shown is not the present, and what happens about it. */

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
  const soon = wait > 0.5 ? `Next attempt in ${Math.ceil(wait)} s.` : "Trying now…";
  const age = store.viewAgeMs.value;
  const replay = store.replay.value;
  const { drives } = store.body.value;
  return (
    <div class={`banner ${phase}`} role="alert" data-testid="banner" data-phase={phase}>
      {phase === "connecting" ? <span class="spinner" aria-hidden="true" /> : <WarnIcon />}
      {phase === "connecting" && (
        <p>
          <b>Connecting to the robot…</b>
          {retryAt > 0 && <span aria-hidden="true">It does not answer yet. {soon}</span>}
        </p>
      )}
      {phase === "stale" && replay && (
        <p>
          <b>The replay does not answer.</b>
          <span>The page continues when it answers.</span>
        </p>
      )}
      {phase === "stale" && !replay && (
        <p>
          <b>The robot does not answer.</b>
          <span>
            The data on this page is <span aria-hidden="true">{age === null ? "" : `${number(age / 1000, 1)} s`}</span>{" "}
            old.
            {drives && " You cannot drive; without commands the robot stops."}
          </span>
        </p>
      )}
      {phase === "lost" && (
        <p>
          <b>
            {replay
              ? "Connection to the replay lost. Reconnecting…"
              : `Connection to the robot lost. ${drives ? "Without commands it stops by itself. " : ""}Reconnecting…`}
          </b>
          <span aria-hidden="true">{soon}</span>
        </p>
      )}
    </div>
  );
}
