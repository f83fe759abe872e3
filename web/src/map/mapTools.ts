/**
 * The tools of the map, as a pure state machine: pointers and keys in; another view, and goals, poses and zones out.
 *
 * With every tool two fingers pan and zoom, the wheel zooms, and the middle or right button pans. One finger or the left
 * button pans or selects (`look`), puts down a place and drags a heading (`goal`, `pose`), or draws a zone: dragged, a
 * rectangle; clicked, corner after corner until the first is met again. `point` takes a click for a point, and pans.
 */

import { type MapView, type Point, panned, type Size, toMap, toScreen, wrapped, zoomed } from "./mapProjection";

export type Tool = "look" | "goal" | "pose" | "keep_out" | "slow" | "point";

/** A corner of the selected zone that can be moved. */
export interface Handle {
  zone: string;
  index: number;
}

export type Act =
  | { kind: "none" }
  /** Down with `look`: a click as long as it has not moved. */
  | { kind: "press"; at: Point }
  | { kind: "pan" }
  | { kind: "pinch" }
  /** A place is chosen (m), and a heading perhaps (rad). */
  | { kind: "aim"; place: Point; heading: number | null; by: "hand" | "keys" }
  /** Down with a zone's tool: a corner, or a rectangle once it has moved. `from` and `to` in m. */
  | { kind: "rectangle"; from: Point; to: Point; moved: boolean }
  | { kind: "corner"; handle: Handle; to: Point };

export interface Tools {
  readonly tool: Tool;
  readonly act: Act;
  /** px. */
  readonly pointers: ReadonlyMap<number, Point>;
  /** Of the zone that is being clicked, m. */
  readonly corners: readonly Point[];
  /** Where a next corner would be, m. */
  readonly hover: Point | null;
  /** Where the arrow keys are, m. */
  readonly cursor: Point | null;
}

export const AT_REST: Tools = {
  tool: "look",
  act: { kind: "none" },
  pointers: new Map(),
  corners: [],
  hover: null,
  cursor: null,
};

export type Input =
  | { type: "down"; id: number; at: Point; button: number; handle?: Handle | null }
  | { type: "move"; id: number; at: Point }
  | { type: "up"; id: number; at: Point }
  | { type: "cancel"; id: number }
  | { type: "leave" }
  | { type: "wheel"; at: Point; factor: number }
  | { type: "key"; key: string; shift: boolean }
  /** The keyboard came to the map, or left it. */
  | { type: "focus"; on: boolean }
  | { type: "tool"; tool: Tool };

export type Wish =
  | { type: "goal"; place: Point; heading: number | null }
  | { type: "pose"; place: Point; heading: number | null }
  | { type: "zone"; kind: "keep_out" | "slow"; polygon: Point[] }
  | { type: "corner"; handle: Handle; to: Point }
  | { type: "select"; at: Point }
  | { type: "point"; at: Point };

export interface Sight {
  view: MapView;
  size: Size;
  /** The robot is kept in the middle: zooming is about the middle. */
  follow: boolean;
}

export interface Done {
  tools: Tools;
  view: MapView;
  wish: Wish | null;
  /** The hand has moved the view away from the robot. */
  panned: boolean;
  /** Whether a key meant something. */
  taken: boolean;
}

const CLICK_PX = 5;
const HEADING_PX = 14;
const MEET_PX = 12;
const STEP_PX = 16;
const LEAP_PX = 64;
const TURN = Math.PI / 12;
const FINE_TURN = Math.PI / 60;
const EDGE_PX = 24;
const NONE: Act = { kind: "none" };

export function step(tools: Tools, input: Input, sight: Sight): Done {
  const done: Done = { tools, view: sight.view, wish: null, panned: false, taken: true };
  switch (input.type) {
    case "tool":
      return { ...done, tools: { ...AT_REST, tool: input.tool, cursor: tools.cursor } };
    case "wheel":
      return { ...done, view: zoomed(sight.view, sight.size, input.factor, sight.follow ? undefined : input.at) };
    case "down":
      return down(done, input, sight);
    case "move":
      return moved(done, input, sight);
    case "up":
      return up(done, input, sight);
    case "cancel":
      return { ...done, tools: { ...tools, pointers: without(tools.pointers, input.id), act: NONE } };
    case "leave":
      return { ...done, tools: { ...tools, hover: null } };
    case "key":
      return key(done, input, sight);
    case "focus":
      return focused(done, input.on, sight);
  }
}

function focused(done: Done, on: boolean, sight: Sight): Done {
  const { tools } = done;
  if (on) return { ...done, tools: { ...tools, cursor: tools.cursor ?? { x: sight.view.x, y: sight.view.y } } };
  // An aim of the keys without keys would stand there for good; corners may be gone on with by hand.
  const act = tools.act.kind === "aim" && tools.act.by === "keys" ? NONE : tools.act;
  return { ...done, tools: { ...tools, act, cursor: null } };
}

/** Whether a tool is in use that Escape cancels. */
export function busy(tools: Tools): boolean {
  return tools.tool !== "look" || tools.corners.length > 0 || tools.act.kind === "aim" || tools.act.kind === "corner";
}

/** The zone as it would be: what is drawn of it while it is made. */
export function sketch(tools: Tools, sight: Sight): Point[] {
  if (tools.act.kind === "rectangle" && tools.act.moved) return rectangle(tools.act.from, tools.act.to, sight);
  const next = tools.hover ?? (tools.corners.length > 0 ? tools.cursor : null);
  return next && tools.corners.length > 0 ? [...tools.corners, next] : [...tools.corners];
}

function down(done: Done, { id, at, button, handle }: Extract<Input, { type: "down" }>, sight: Sight): Done {
  const { tools } = done;
  const pointers = new Map(tools.pointers).set(id, at);
  const with_ = (act: Act): Done => ({ ...done, tools: { ...tools, pointers, act, hover: null } });
  // A second finger means the view, whatever the first began.
  if (pointers.size > 1) return with_({ kind: "pinch" });
  if (button !== 0) return with_({ kind: "pan" });
  const place = toMap(sight.view, sight.size, at);
  if (handle && tools.tool === "look") return with_({ kind: "corner", handle, to: place });
  if (tools.tool === "look" || tools.tool === "point") return with_({ kind: "press", at });
  if (tools.tool === "goal" || tools.tool === "pose") return with_({ kind: "aim", place, heading: null, by: "hand" });
  return with_({ kind: "rectangle", from: place, to: place, moved: false });
}

function moved(done: Done, { id, at }: Extract<Input, { type: "move" }>, sight: Sight): Done {
  const { tools } = done;
  const before = tools.pointers.get(id);
  const place = toMap(sight.view, sight.size, at);
  if (!before) return tools.corners.length > 0 ? { ...done, tools: { ...tools, hover: place } } : done;
  const pointers = new Map(tools.pointers).set(id, at);
  const with_ = (act: Act): Done => ({ ...done, tools: { ...tools, pointers, act } });
  const { act } = tools;
  switch (act.kind) {
    case "pinch":
      return { ...with_(act), ...pinched(tools.pointers, pointers, sight), panned: !sight.follow };
    case "press":
      if (distance(act.at, at) <= CLICK_PX) return with_(act);
      return { ...with_({ kind: "pan" }), view: panned(sight.view, at.x - act.at.x, at.y - act.at.y), panned: true };
    case "pan":
      return { ...with_(act), view: panned(sight.view, at.x - before.x, at.y - before.y), panned: true };
    case "aim": {
      const far = distance(toScreen(sight.view, sight.size, act.place), at) >= HEADING_PX;
      const heading = Math.atan2(place.y - act.place.y, place.x - act.place.x);
      return with_({ ...act, heading: far ? heading : null });
    }
    case "rectangle": {
      const far = act.moved || distance(toScreen(sight.view, sight.size, act.from), at) > CLICK_PX;
      // Corner after corner, a moving finger is only an unsteady one.
      return with_({ ...act, to: place, moved: far && tools.corners.length === 0 });
    }
    case "corner":
      return with_({ ...act, to: place });
    case "none":
      return with_(act);
  }
}

function up(done: Done, { id, at }: Extract<Input, { type: "up" }>, sight: Sight): Done {
  const { tools } = done;
  const pointers = without(tools.pointers, id);
  // The finger that is left of two pans no more until it is put down again.
  const rest: Tools = { ...tools, pointers, act: NONE };
  const place = toMap(sight.view, sight.size, at);
  const { act, tool } = tools;
  if (!tools.pointers.has(id)) return done;
  if (act.kind === "press")
    return { ...done, tools: rest, wish: { type: tool === "point" ? "point" : "select", at: place } };
  if (act.kind === "corner") return { ...done, tools: rest, wish: { type: "corner", handle: act.handle, to: act.to } };
  if (act.kind === "aim" && act.by === "hand") return aimed(done, { ...rest, act }, act);
  if (act.kind === "rectangle" && (tool === "keep_out" || tool === "slow")) {
    if (act.moved) return drawn(done, rest, tool, rectangle(act.from, act.to, sight));
    return corner(done, rest, tool, act.from, sight);
  }
  return { ...done, tools: rest };
}

function aimed(done: Done, tools: Tools, act: Extract<Act, { kind: "aim" }>): Done {
  const type = tools.tool === "pose" ? "pose" : "goal";
  // A goal may follow a goal; the robot is placed once.
  const tool = type === "pose" ? "look" : tools.tool;
  return {
    ...done,
    tools: { ...tools, act: NONE, tool },
    wish: { type, place: act.place, heading: act.heading },
  };
}

/** One more corner; the first or the last one again closes the zone. */
function corner(done: Done, tools: Tools, kind: "keep_out" | "slow", place: Point, sight: Sight): Done {
  const near = (other: Point | undefined) =>
    !!other && distance(toScreen(sight.view, sight.size, other), toScreen(sight.view, sight.size, place)) <= MEET_PX;
  const { corners } = tools;
  if (corners.length >= 3 && (near(corners[0]) || near(corners.at(-1)))) return drawn(done, tools, kind, [...corners]);
  if (near(corners.at(-1))) return { ...done, tools };
  return { ...done, tools: { ...tools, corners: [...corners, place] } };
}

function drawn(done: Done, tools: Tools, kind: "keep_out" | "slow", polygon: Point[]): Done {
  return { ...done, tools: { ...AT_REST, cursor: tools.cursor }, wish: { type: "zone", kind, polygon } };
}

function key(done: Done, { key, shift }: Extract<Input, { type: "key" }>, sight: Sight): Done {
  const { tools } = done;
  const { act, tool } = tools;
  const aiming = act.kind === "aim" && act.by === "keys" ? act : null;
  if (key === "Escape") {
    if (aiming) return { ...done, tools: { ...tools, act: NONE } };
    if (!busy(tools)) return { ...done, taken: false };
    return { ...done, tools: { ...AT_REST, tool: tools.corners.length > 0 ? tool : "look", cursor: tools.cursor } };
  }
  if (key === "Backspace" && aiming) return { ...done, tools: { ...tools, act: NONE } };
  if (key === "Backspace" && tools.corners.length > 0)
    return { ...done, tools: { ...tools, corners: tools.corners.slice(0, -1) } };
  if (key === "+" || key === "=") return { ...done, view: zoomed(sight.view, sight.size, 1.25) };
  if (key === "-") return { ...done, view: zoomed(sight.view, sight.size, 0.8) };
  if (key === "Enter") return entered(done, sight);
  const [x, y] = ARROWS[key] ?? [0, 0];
  if (x === 0 && y === 0) return { ...done, taken: false };
  if (aiming) {
    // The first press points where the arrow does; then left is counter-clockwise.
    const turn = aiming.heading !== null && x !== 0;
    const by = -x * (shift ? FINE_TURN : TURN);
    const heading = turn ? aiming.heading! + by : sight.view.up + Math.atan2(-x, -y);
    return { ...done, tools: { ...tools, act: { ...aiming, heading: wrapped(heading) } } };
  }
  return cursorMoved(done, x, y, shift ? LEAP_PX : STEP_PX, sight);
}

const ARROWS: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

function entered(done: Done, sight: Sight): Done {
  const { tools } = done;
  const { act, tool } = tools;
  if (act.kind === "aim" && act.by === "keys") return aimed(done, tools, act);
  const cursor = tools.cursor ?? { x: sight.view.x, y: sight.view.y };
  if (tool === "keep_out" || tool === "slow") return corner(done, { ...tools, cursor }, tool, cursor, sight);
  if (tool === "point") return { ...done, tools: { ...tools, cursor }, wish: { type: "point", at: cursor } };
  const aim: Act = { kind: "aim", place: cursor, heading: null, by: "keys" };
  return { ...done, tools: { ...tools, cursor, tool: tool === "look" ? "goal" : tool, act: aim } };
}

/** The view goes with the cursor where it would leave it. */
function cursorMoved(done: Done, x: number, y: number, by: number, sight: Sight): Done {
  const { size } = sight;
  const from = done.tools.cursor
    ? toScreen(sight.view, size, done.tools.cursor)
    : { x: size.width / 2, y: size.height / 2 };
  const to = { x: from.x + x * by, y: from.y + y * by };
  const within = {
    x: Math.max(EDGE_PX, Math.min(size.width - EDGE_PX, to.x)),
    y: Math.max(EDGE_PX, Math.min(size.height - EDGE_PX, to.y)),
  };
  const cursor = toMap(sight.view, size, to);
  const [dx, dy] = [within.x - to.x, within.y - to.y];
  const moves = dx !== 0 || dy !== 0;
  return {
    ...done,
    tools: { ...done.tools, cursor, hover: null },
    view: moves ? panned(sight.view, dx, dy) : sight.view,
    panned: moves,
  };
}

function pinched(before: ReadonlyMap<number, Point>, now: ReadonlyMap<number, Point>, sight: Sight): { view: MapView } {
  const [a, b] = [...before.values()];
  const [c, d] = [...now.values()];
  if (!a || !b || !c || !d) return { view: sight.view };
  const [from, to] = [between(a, b), between(c, d)];
  const [was, is] = [distance(a, b), distance(c, d)];
  const factor = was > 10 && is > 10 ? is / was : 1;
  if (sight.follow) return { view: zoomed(sight.view, sight.size, factor) };
  return { view: panned(zoomed(sight.view, sight.size, factor, from), to.x - from.x, to.y - from.y) };
}

/** Upright on the screen, whichever direction is up. */
function rectangle(from: Point, to: Point, { view, size }: Sight): Point[] {
  const [a, c] = [toScreen(view, size, from), toScreen(view, size, to)];
  return [a, { x: c.x, y: a.y }, c, { x: a.x, y: c.y }].map((corner) => toMap(view, size, corner));
}

function without(pointers: ReadonlyMap<number, Point>, id: number): ReadonlyMap<number, Point> {
  const rest = new Map(pointers);
  rest.delete(id);
  return rest;
}

function between(a: Point, b: Point): Point {
  return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
}

function distance(a: Point, b: Point): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
