/** Between the map and the screen: pan, zoom, turn, fit, the scale bar. Pure. */

/** m on the map, or px on the screen. */
export interface Point {
  x: number;
  y: number;
}

/** px. */
export interface Size {
  width: number;
  height: number;
}

export interface Pose extends Point {
  theta: number;
}

/** m on the map, along its axes. */
export interface Bounds {
  left: number;
  bottom: number;
  right: number;
  top: number;
}

export interface MapView {
  /** What of the map is in the middle of the screen, m. */
  x: number;
  y: number;
  /** px of one metre. */
  scale: number;
  /** The direction on the map that points up on the screen, rad. */
  up: number;
}

export const NORTH = Math.PI / 2;
export const FIRST_VIEW: MapView = { x: 0, y: 0, scale: 28, up: NORTH };
const CLOSEST = 400;
const FARTHEST = 1.5;
/** m; nothing less is spread over the screen. */
const LEAST = 6;
const EVEN = { left: 18, top: 18, right: 18, bottom: 18 };

export function toScreen(view: MapView, size: Size, point: Point): Point {
  const { cos, sin } = turnOf(view);
  const [dx, dy] = [point.x - view.x, point.y - view.y];
  return {
    x: size.width / 2 + view.scale * (cos * dx - sin * dy),
    y: size.height / 2 - view.scale * (sin * dx + cos * dy),
  };
}

export function toMap(view: MapView, size: Size, point: Point): Point {
  const { cos, sin } = turnOf(view);
  const [rx, ry] = [(point.x - size.width / 2) / view.scale, (size.height / 2 - point.y) / view.scale];
  return { x: view.x + cos * rx + sin * ry, y: view.y - sin * rx + cos * ry };
}

/** The angle on the screen (rad, from its x axis, downwards) of a direction on the map. */
export function screenAngle(view: MapView, theta: number): number {
  return view.up - NORTH - theta;
}

/** As `setTransform` takes it: from metres on the map to px. */
export function matrix(view: MapView, size: Size): [number, number, number, number, number, number] {
  const { cos, sin } = turnOf(view);
  const s = view.scale;
  const origin = toScreen(view, size, { x: 0, y: 0 });
  return [s * cos, -s * sin, -s * sin, -s * cos, origin.x, origin.y];
}

/** Moves what is under the hand by so many px. */
export function panned(view: MapView, dx: number, dy: number): MapView {
  const { cos, sin } = turnOf(view);
  const [rx, ry] = [-dx / view.scale, dy / view.scale];
  return { ...view, x: view.x + cos * rx + sin * ry, y: view.y - sin * rx + cos * ry };
}

/** Closer (over 1) or farther; what of the map is at `anchor` (px) stays there. */
export function zoomed(view: MapView, size: Size, factor: number, anchor?: Point): MapView {
  const scale = Math.max(FARTHEST, Math.min(CLOSEST, view.scale * factor));
  const next = { ...view, scale };
  if (!anchor) return next;
  const kept = toMap(view, size, anchor);
  const moved = toScreen(next, size, kept);
  return panned(next, anchor.x - moved.x, anchor.y - moved.y);
}

/** Another direction upwards, around the middle of the screen. */
export function turned(view: MapView, up: number): MapView {
  return { ...view, up };
}

/** px around what is to be seen. */
export interface Margins {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

/** All of `bounds`, within the margins. */
export function fitted(view: MapView, size: Size, bounds: Bounds, margins: Margins = EVEN): MapView {
  const { cos, sin } = turnOf(view);
  const [wide, high] = [Math.max(LEAST, bounds.right - bounds.left), Math.max(LEAST, bounds.top - bounds.bottom)];
  const across = Math.abs(cos) * wide + Math.abs(sin) * high;
  const upright = Math.abs(sin) * wide + Math.abs(cos) * high;
  const [room, height] = [size.width - margins.left - margins.right, size.height - margins.top - margins.bottom];
  const scale = Math.max(FARTHEST, Math.min(CLOSEST, room / across, height / upright));
  const middle = { x: (bounds.left + bounds.right) / 2, y: (bounds.bottom + bounds.top) / 2 };
  return panned({ ...view, ...middle, scale }, (margins.left - margins.right) / 2, (margins.top - margins.bottom) / 2);
}

/** A length to show beside the map: 1, 2 or 5 of a power of ten, at most `most` px long. */
export function scaleBar(scale: number, most: number): { metres: number; px: number } {
  const power = 10 ** Math.floor(Math.log10(most / scale));
  const metres = [5, 2, 1].map((one) => one * power).find((one) => one * scale <= most)!;
  return { metres, px: metres * scale };
}

/** `second` as seen from `first`'s own frame's parent: first ∘ second. */
export function composed(first: Pose, second: Pose): Pose {
  const [cos, sin] = [Math.cos(first.theta), Math.sin(first.theta)];
  return {
    x: first.x + cos * second.x - sin * second.y,
    y: first.y + sin * second.x + cos * second.y,
    theta: wrapped(first.theta + second.theta),
  };
}

/** Into −π…π. */
export function wrapped(angle: number): number {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

function turnOf(view: MapView): { cos: number; sin: number } {
  const turn = NORTH - view.up;
  return { cos: Math.cos(turn), sin: Math.sin(turn) };
}
