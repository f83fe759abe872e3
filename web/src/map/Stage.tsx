/** The canvas of the map, the hands on it, and what lies over it: where the robot is, how it is looked at, why it is empty. */

import { effect, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { useApp } from "../state/context";
import { number } from "../ui/format";
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
import { handleAt } from "./control";
import { draw } from "./draw";
import { sketch } from "./hands";
import { composed, type Point, toScreen } from "./projection";
import { emptyWords, goalOf, poseWords } from "./words";

/** `children`: words that lie over the map, where it has all of the view. */
export function Stage({ place, children }: { place: "tab" | "view"; children?: ComponentChildren }) {
  const { map, grid } = useApp();
  const canvas = useRef<HTMLCanvasElement>(null);
  const said = useSignal("");
  const paintOn = usePainter();
  useEffect(() => paintOn(canvas.current!, place), []);
  useEffect(() => handsOn(canvas.current!, map, (words) => (said.value = words)), []);
  const { tool } = map.hands.value;
  const { x, y, scale, up } = map.view.value;
  const robot = map.robot.value;
  return (
    <div class={`map-stage tool-${tool}`}>
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
        aria-label="Map. Arrow keys move a cursor, Enter sets a goal there, plus and minus zoom."
      />
      <div class="map-over">
        <Where />
        {children}
      </div>
      <ViewButtons />
      <Empty />
      <p class="visually-hidden" aria-live="polite">
        {said.value}
      </p>
    </div>
  );
}

/** Where the robot is, in words. */
function Where() {
  const { store } = useApp();
  const localization = store.localization.value;
  if (!localization) return null;
  const { tone, text, more } = poseWords(localization);
  const trouble = tone !== "good";
  return (
    <p
      class={`map-where ${tone}`}
      role="status"
      data-testid="map-where"
      data-state={localization.state}
      data-map={localization.map}
      title={more}
    >
      <b>{text}</b>
      <span class={trouble ? "" : "map-sigma"}>{more}</span>
    </p>
  );
}

function ViewButtons() {
  const { map, store, grid } = useApp();
  const large = store.mapPlace.value === "view";
  const toggles = [
    { id: "follow", label: "Follow the robot", icon: <FollowIcon />, state: map.follow },
    { id: "robot-up", label: "The robot's heading up, instead of north", icon: <CompassIcon />, state: map.robotUp },
    { id: "costmap", label: "Show what it keeps clear of just now", icon: <LayersIcon />, state: map.costmap },
  ];
  return (
    <div class="map-view-buttons" role="group" aria-label="How the map is looked at">
      <button
        type="button"
        class="icon-button"
        data-testid="map-enlarge"
        title={large ? "Back beside the view (M)" : "Over all of the view (M)"}
        aria-label={large ? "Shrink the map" : "Enlarge the map"}
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
        title="All of the map"
        aria-label="Show all of the map"
        onClick={() => map.fit(grid.map.picture.value)}
      >
        <FitIcon />
      </button>
      <button type="button" class="icon-button map-zoom" data-testid="map-closer" aria-label="Closer" title="Closer (+)" onClick={() => map.zoom(1.4)}>
        <PlusIcon />
      </button>
      <button type="button" class="icon-button map-zoom" data-testid="map-farther" aria-label="Farther" title="Farther (−)" onClick={() => map.zoom(1 / 1.4)}>
        <MinusIcon />
      </button>
    </div>
  );
}

function Empty() {
  const { store, map, grid } = useApp();
  if (grid.map.picture.value) return null;
  const lane = store.rows.value.find((row) => row.class === "SLAM");
  const slam = store.hello.value?.channels.map === false ? undefined : lane;
  const { text, more, desire } = emptyWords(store.live.value, store.replay.value, slam, store.localization.value);
  return (
    <div class="map-empty" data-testid="map-empty">
      <p>{text}</p>
      {more && <p class="muted">{more}</p>}
      {desire && map.allowed.value && (
        <button type="button" class="button small" data-testid="map-desire" onClick={() => void map.desireMap()}>
          Begin to map
        </button>
      )}
    </div>
  );
}

/** Paints at the next frame after any change; returns what ends it. */
function usePainter() {
  const { store, map, grid } = useApp();
  return (canvas: HTMLCanvasElement, place: "tab" | "view") => {
    let frame = 0;
    const size = { width: 0, height: 0 };
    const paint = () => {
      frame = 0;
      if (size.width < 1) return;
      const localization = store.localization.peek();
      const X_MO = localization?.X_MO ?? null;
      const navigation = store.navigation.peek();
      const going = navigation && navigation.state !== "idle" && navigation.state !== "arrived" ? navigation : null;
      const hands = map.hands.peek();
      const onMap = ({ x, y }: Point) => (X_MO ? [composed(X_MO, { x, y, theta: 0 })] : []);
      draw(canvas.getContext("2d")!, size, map.view.peek(), {
        map: grid.map.picture.peek(),
        costmap: map.costmap.peek() ? grid.costmap.picture.peek() : null,
        X_MO,
        robot: map.robot.peek(),
        sigma: localization?.sigma ?? [0, 0, 0],
        astray: localization?.state === "lost" || localization?.state === "searching",
        footprint: store.hello.peek()?.robot.footprint ?? [],
        path: going?.path ?? [],
        goal: goalOf(store.desires.peek()) ?? going?.goal ?? null,
        target: going?.target ?? null,
        zones: map.zones.peek(),
        selected: map.selected.peek(),
        tool: hands.tool,
        act: hands.act,
        sketch: sketch(hands, map.sight),
        cursor: hands.cursor,
        roomy: place === "view",
        people: (store.perceived.peek()?.faces ?? []).flatMap(({ x, y }) => (x === null || y === null ? [] : onMap({ x, y }))),
        posters: (store.landmarks.peek() ?? []).flatMap(({ x, y, text }) => onMap({ x, y }).map((place) => ({ ...place, text }))),
      });
    };
    const later = () => {
      if (!frame) frame = requestAnimationFrame(paint);
    };
    const sized = new ResizeObserver(() => {
      size.width = canvas.clientWidth;
      size.height = canvas.clientHeight;
      const density = Math.min(2, window.devicePixelRatio || 1);
      canvas.width = Math.round(size.width * density);
      canvas.height = Math.round(size.height * density);
      map.resize({ ...size }, place);
      map.met(grid.map.picture.peek());
      cancelAnimationFrame(frame);
      paint();
    });
    sized.observe(canvas);
    const end = effect(() => {
      void [store.localization.value, store.navigation.value, store.desires.value, store.perceived.value, store.landmarks.value];
      void [map.view.value, map.hands.value, map.robot.value, map.zones.value, map.selected.value, map.costmap.value];
      void [grid.costmap.picture.value, store.hello.value];
      map.met(grid.map.picture.value);
      later();
    });
    return () => {
      end();
      sized.disconnect();
      cancelAnimationFrame(frame);
    };
  };
}

/** Pointers, wheel and keys into the state machine; returns the undoing. `say` is for who does not see the cursor. */
function handsOn(canvas: HTMLCanvasElement, map: ReturnType<typeof useApp>["map"], say: (words: string) => void): () => void {
  const at = (event: MouseEvent): Point => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const down = (event: PointerEvent) => {
    if (!map.allowed.peek() && map.hands.peek().tool !== "look") return;
    canvas.setPointerCapture(event.pointerId);
    const { view, size } = map.sight;
    const handle = handleAt(map.zones.peek(), map.selected.peek(), at(event), (point) => toScreen(view, size, point));
    map.input({ type: "down", id: event.pointerId, at: at(event), button: event.button, handle });
  };
  const move = (event: PointerEvent) => void map.input({ type: "move", id: event.pointerId, at: at(event) });
  const up = (event: PointerEvent) => void map.input({ type: "up", id: event.pointerId, at: at(event) });
  const cancel = (event: PointerEvent) => void map.input({ type: "cancel", id: event.pointerId });
  const leave = () => void map.input({ type: "leave" });
  const wheel = (event: WheelEvent) => {
    event.preventDefault();
    map.input({ type: "wheel", at: at(event), factor: Math.exp(-event.deltaY * 0.0016) });
  };
  const key = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.key === "Escape") return;
    if (event.key === "Enter" && !map.allowed.peek()) return;
    if (!map.input({ type: "key", key: event.key, shift: event.shiftKey })) return;
    event.preventDefault();
    event.stopPropagation();
    say(cursorWords(map));
  };
  // A click looks, it does not take the arrow keys away from driving; Tab does.
  const stay = (event: Event) => event.preventDefault();
  const listeners: [string, (event: never) => void][] = [
    ["pointerdown", down],
    ["pointermove", move],
    ["pointerup", up],
    ["pointercancel", cancel],
    ["pointerleave", leave],
    ["mousedown", stay],
    ["contextmenu", stay],
    ["keydown", key],
  ];
  for (const [type, listener] of listeners) canvas.addEventListener(type, listener as EventListener);
  canvas.addEventListener("wheel", wheel, { passive: false });
  return () => {
    for (const [type, listener] of listeners) canvas.removeEventListener(type, listener as EventListener);
    canvas.removeEventListener("wheel", wheel);
  };
}

function cursorWords(map: ReturnType<typeof useApp>["map"]): string {
  const { cursor, act, corners } = map.hands.peek();
  if (!cursor) return "";
  const where = `${number(cursor.x, 1)}, ${number(cursor.y, 1)} metres`;
  if (act.kind === "aim") {
    const heading = act.heading === null ? "no heading yet" : `heading ${number((act.heading * 180) / Math.PI, 0)} degrees`;
    return `Place ${where}, ${heading}. Arrows turn it, Enter sends it, Escape gives it up.`;
  }
  return corners.length > 0 ? `Corner ${corners.length + 1} at ${where}` : where;
}
