/** The canvas of the map, its pointers and keys, and what lies over it: where the robot is, how it is looked at, why it is empty. */

import { effect, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { useApp } from "../state/context";
import type { MapPlace } from "../state/store";
import { ago } from "../ui/format";
import {
  CompassIcon,
  EnlargeIcon,
  FitIcon,
  FollowIcon,
  LayersIcon,
  MinusIcon,
  PlusIcon,
  ShrinkIcon,
} from "../ui/icons";
import { listen } from "./listeners";
import { emptyWords, poseWords } from "./mapText";
import { paintOn } from "./painter";

/** A pose that is older (s of the robot, at its own pace) says so. */
const OLD_S = 3;

interface Props {
  place: MapPlace;
  /** Whether the buttons of how it is looked at lie over it. */
  buttons: boolean;
  /** Words that lie over it, where it has all of the view. */
  children?: ComponentChildren;
}

export function Stage({ place, buttons, children }: Props) {
  const app = useApp();
  const { map, grid } = app;
  const canvas = useRef<HTMLCanvasElement>(null);
  const said = useSignal("");
  useEffect(() => paintOn(canvas.current!, place, app), []);
  useEffect(() => listen(canvas.current!, map, (words) => (said.value = words)), []);
  useEffect(
    () =>
      effect(() => {
        if (!map.called.value) return;
        map.called.value = false;
        canvas.current!.focus({ preventScroll: false });
      }),
    [],
  );
  const { tool } = map.tools.value;
  const { x, y, scale, up } = map.view.value;
  const robot = map.robot.value;
  return (
    <div class={`map-stage tool-${tool}`}>
      {/* biome-ignore lint/a11y/noInteractiveElementToNoninteractiveRole: an application takes keys, as this map does */}
      <canvas
        ref={canvas}
        class="map-canvas"
        data-testid="map-canvas"
        data-own-arrows
        data-x={x}
        data-y={y}
        data-scale={scale}
        data-up={up}
        data-version={grid.map.picture.value?.info.version ?? ""}
        data-robot={robot ? [robot.x, robot.y, robot.theta].map((value) => value.toFixed(3)).join(" ") : ""}
        tabIndex={0}
        role="application"
        aria-label={t("Map. Arrow keys move a cursor, Enter sets a goal there, plus and minus zoom.")}
      />
      <div class="map-over">
        <Where />
        {children}
      </div>
      {buttons && <ViewButtons />}
      <Empty />
      <p class="visually-hidden" aria-live="polite">
        {said.value}
      </p>
    </div>
  );
}

/** Where the robot is, in words. */
function Where() {
  const { store, maps } = useApp();
  const localization = store.of("localization").value;
  if (!localization) return null;
  const lane = store.rows.value.find((row) => row.class === "SLAM");
  const name = maps.inUse.value ?? localization.map;
  const { tone, text, more } = poseWords(localization, store.replay.value ? undefined : lane, name);
  const trouble = tone !== "good";
  const age = (store.seconds.value ?? localization.stamp) - localization.stamp;
  return (
    <p
      class={`map-where ${tone}`}
      role="status"
      data-testid="map-where"
      data-state={localization.state}
      data-map={name}
      title={more}
    >
      <b>{age > OLD_S * Math.max(1, store.clock.rate) ? t("{text}, {ago}", { text, ago: ago(age) }) : text}</b>
      <span class={trouble ? "" : "map-sigma"}>{more}</span>
    </p>
  );
}

export function ViewButtons() {
  const { map, store, grid } = useApp();
  const large = store.mapPlace.value === "view";
  const toggles = [
    { id: "follow", label: t("Follow the robot"), icon: <FollowIcon />, state: map.follow },
    { id: "robot-up", label: t("Robot's heading up instead of north"), icon: <CompassIcon />, state: map.robotUp },
    { id: "costmap", label: t("Show the local costmap"), icon: <LayersIcon />, state: map.costmap },
  ];
  return (
    <div class="map-view-buttons" role="group" aria-label={t("Map view")}>
      <button
        type="button"
        class="icon-button"
        data-testid="map-enlarge"
        title={large ? t("Back beside the view (M)") : t("Map over the whole view (M)")}
        aria-label={large ? t("Shrink the map") : t("Enlarge the map")}
        aria-pressed={large}
        onClick={() => store.showMap(large ? "tab" : "view")}
      >
        {large ? <ShrinkIcon /> : <EnlargeIcon />}
      </button>
      {toggles
        .filter(({ id }) => id !== "costmap" || store.hello.value?.channels.costmap)
        .map(({ id, label, icon, state }) => (
          <button
            key={id}
            type="button"
            class={`icon-button ${state.value ? "on" : ""}`}
            data-testid={`map-${id}`}
            title={label}
            aria-label={label}
            aria-pressed={state.value}
            onClick={() => (state.value = !state.value)}
          >
            {icon}
          </button>
        ))}
      <button
        type="button"
        class="icon-button"
        data-testid="map-fit"
        title={t("All of the map")}
        aria-label={t("Show all of the map")}
        onClick={() => map.fit(grid.map.picture.value)}
      >
        <FitIcon />
      </button>
      <button
        type="button"
        class="icon-button map-zoom"
        data-testid="map-closer"
        aria-label={t("Closer")}
        title={t("Closer (+)")}
        onClick={() => map.zoom(1.4)}
      >
        <PlusIcon />
      </button>
      <button
        type="button"
        class="icon-button map-zoom"
        data-testid="map-farther"
        aria-label={t("Farther")}
        title={t("Farther (−)")}
        onClick={() => map.zoom(1 / 1.4)}
      >
        <MinusIcon />
      </button>
    </div>
  );
}

function Empty() {
  const { store, map, grid } = useApp();
  if (grid.map.picture.value?.known) return null;
  const lane = store.rows.value.find((row) => row.class === "SLAM");
  const slam = store.hello.value?.channels.map === false ? undefined : lane;
  const { text, more, desire } = emptyWords(store.live.value, store.replay.value, slam, store.of("localization").value);
  return (
    <div class="map-empty" data-testid="map-empty">
      <p>{text}</p>
      {more && <p class="muted">{more}</p>}
      {desire && map.allowed.value && (
        <button type="button" class="button small" data-testid="map-desire" onClick={() => void map.desireMap()}>
          {t("Start mapping")}
        </button>
      )}
    </div>
  );
}
