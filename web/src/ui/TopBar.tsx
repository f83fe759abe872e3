/** Always visible: who, what, how fresh, and the stop. */

import type { ComponentChildren } from "preact";
import { WheelAsked } from "../drive/Wheel";
import { FleetMenu } from "../fleet/FleetMenu";
import { decimals, fromRobot, t } from "../i18n";
import { LayoutMenu } from "../layout/LayoutMenu";
import { ShapedLink } from "../panels/ShapedLink";
import { Marker } from "../playback/Marker";
import { RecordButton } from "../recordings/RecordButton";
import { useApp } from "../state/context";
import { Battery } from "./Battery";
import { cautionWords } from "./cautions";
import { driverName, driverWords } from "./driver";
import { EStop } from "./EStop";
import { millis } from "./format";
import { LinkIcon, WarnIcon } from "./icons";
import { motionWords } from "./motion";
import { NameAsk } from "./NameAsk";
import { Operator } from "./Operator";

const PHASES = {
  connecting: "Connecting…",
  live: "Connected",
  stale: "No answer",
  lost: "Lost",
  login: "Log in",
} as const;

export function TopBar({ narrow }: { narrow: boolean }) {
  const { store } = useApp();
  const phase = store.link.value.phase;
  const status = store.of("status").value;
  const live = phase === "live";
  const guard = status?.guard;
  const known = live ? guard : undefined;
  const odometry = status?.sources.some((each) => each.channel === "odometry" && each.state === "stale")
    ? null
    : (status?.odometry ?? null);
  const replay = store.replay.value;
  const stopped = store.stopped.value && !replay;
  const hello = store.hello.value;
  const rate = status?.world_rate ?? 1;
  const caution = replay ? null : cautionWords(hello?.robot.cautions ?? []);
  const slow = live && !replay && rate < 0.99;
  return (
    <header class={`top-bar ${stopped ? "stopped" : ""} ${phase}`}>
      <div class="bar-info">
        <div class="brand">
          <h1>HBBA</h1>
          <span class="robot-name" data-testid="robot-name">
            {replay ? t("Replay") : <FleetMenu />}
            {!replay && hello?.robot.simulated && <i class="tag">{t("simulated")}</i>}
          </span>
        </div>
        <p class={`chip link-${phase}`} role="status" data-testid="connection" data-phase={phase}>
          {phase === "stale" || phase === "lost" ? <WarnIcon /> : <LinkIcon />}
          {t(PHASES[phase])}
        </p>
        {replay ? (
          <Marker />
        ) : (
          <p
            class={`chip guard-${known?.state ?? "none"}`}
            data-testid="guard-state"
            data-state={known?.state ?? ""}
            title={known && fromRobot(known.reason)}
          >
            {known ? motionWords(known, odometry) : t("State unknown")}
          </p>
        )}
        {caution && (
          <p class="chip warn caution" role="status" data-testid="caution" title={caution.text}>
            <WarnIcon />
            {caution.title}
          </p>
        )}
        <ShapedLink />
        {slow && (
          <p
            class="chip warn world-rate"
            data-testid="world-rate"
            title={t("The simulated world runs slower than real time")}
          >
            <WarnIcon />
            <span>
              <span class="roomy">{t("World runs at")} </span>
              {decimals(rate.toFixed(2))}×<span class="roomy"> {t("real time")}</span>
            </span>
          </p>
        )}
        <dl class="metrics">
          <Battery />
          <Metric
            id="rtt"
            label={t("Link")}
            unit="ms"
            tone={tone(store.rttMs.value, 150, 400)}
            hint={
              replay
                ? t("Round-trip time between this page and the replay")
                : t("Round-trip time between this page and the robot")
            }
          >
            {millis(store.rttMs.value)}
          </Metric>
          {!replay && <LiveMetrics />}
        </dl>
      </div>
      <div class="bar-end">
        <RecordButton />
        {!narrow && <LayoutMenu />}
        <Operator />
        <button
          type="button"
          class="icon-button"
          aria-label={t("Keyboard shortcuts")}
          aria-expanded={store.help.value}
          data-testid="help"
          onClick={() => (store.help.value = !store.help.value)}
        >
          ?
        </button>
        {!narrow && !replay && <EStop />}
      </div>
      <WheelAsked />
      <NameAsk />
    </header>
  );
}

/** What only a living robot has: commands, an age, a driver. */
function LiveMetrics() {
  const { store } = useApp();
  const status = store.of("status").value;
  const live = store.live.value;
  const guard = status?.guard;
  const modules = store.of("load").value?.modules ?? [];
  const { drives, goes } = store.body.value;
  return (
    <>
      {drives && (
        <Metric
          id="command-age"
          label={t("Command")}
          unit="ms"
          tone={live && guard && guard.state !== "idle" ? tone(commandAge(guard), 120, 200) : ""}
          hint={t("Age of the newest drive command at the robot")}
        >
          {live ? millis(commandAge(guard)) : "–"}
        </Metric>
      )}
      <Metric
        id="view-age"
        label={t("View")}
        unit="ms"
        tone={live ? tone(store.viewAgeMs.value, 200, 500) : ""}
        hint={t("Age of the data on this page")}
      >
        {live ? millis(store.viewAgeMs.value) : "–"}
      </Metric>
      {(drives || goes) && (
        <Metric
          id="driver"
          label={t("Drives")}
          hint={live ? driverWords(status, modules) : t("Who drives the robot: not known")}
        >
          {live ? driverName(status, modules) : "–"}
        </Metric>
      )}
    </>
  );
}

function Metric(props: {
  id: string;
  label: string;
  unit?: string;
  tone?: string;
  hint: string;
  children: ComponentChildren;
}) {
  return (
    <div class={`metric ${props.tone ?? ""}`} title={props.hint}>
      <dt>{props.label}</dt>
      <dd data-testid={props.id}>
        {props.children}
        {props.unit && <span class="unit"> {props.unit}</span>}
      </dd>
    </div>
  );
}

/** A command that is not renewed only grows older: after a second its age says nothing about the link. */
function commandAge(guard: { command_age_ms: number | null; state: string } | undefined): number | null {
  const age = guard?.command_age_ms ?? null;
  return age !== null && age < 1000 ? age : null;
}

function tone(value: number | null, fair: number, poor: number): string {
  if (value === null) return "";
  return value >= poor ? "poor" : value >= fair ? "fair" : "";
}
