/** Draws what stands on the map: the robot and how sure it is, goals, the start, people, posters, the cursor. */

import type { SoftLimit } from "../drive/viewFollow";
import { t } from "../i18n";
import { type Context, disc, FONT, outlined, stroke, trace } from "./canvas";
import * as colors from "./colors";
import { type MapView, type Point, type Pose, screenAngle } from "./mapProjection";

/** What is drawn of a robot. */
export interface Body {
  /** Corners in its own axes, m; none: a disc. */
  footprint: readonly (readonly [number, number])[];
  /** Standard deviations of its pose: x, y (m), theta (rad). */
  sigma: readonly [number, number, number];
  /** It does not know where it is: where it was last is drawn faintly. */
  astray: boolean;
}

/** Characters of a name that is drawn whole. */
const LONGEST = 24;
/** The robot is never drawn smaller. */
const LEAST_ROBOT_PX = 9;

export function drawRobot(context: Context, view: MapView, place: Point, robot: Pose, body: Body): void {
  const [sx, sy, st] = body.sigma;
  context.save();
  context.translate(place.x, place.y);
  if (body.astray) context.globalAlpha = 0.45;
  else drawUnsure(context, view, robot, sx, sy, st);
  context.rotate(screenAngle(view, robot.theta));
  const outline = body.footprint.length > 2 ? body.footprint : null;
  const reach = view.scale * (outline ? Math.max(...outline.map(([x, y]) => Math.hypot(x, y))) : 0.3);
  const grown = Math.max(1, LEAST_ROBOT_PX / reach);
  if (outline) {
    const corners = outline.map(([x, y]) => ({ x: x * view.scale * grown, y: -y * view.scale * grown }));
    trace(context, corners, true);
  } else disc(context, { x: 0, y: 0 }, reach * grown);
  context.fillStyle = "rgb(255 255 255 / 0.3)";
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = colors.ROBOT;
  context.stroke();
  const arrow = Math.max(LEAST_ROBOT_PX, reach) * 0.82;
  context.beginPath();
  context.moveTo(arrow, 0);
  context.lineTo(-0.7 * arrow, 0.66 * arrow);
  context.lineTo(-0.35 * arrow, 0);
  context.lineTo(-0.7 * arrow, -0.66 * arrow);
  context.closePath();
  context.fillStyle = colors.ROBOT;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = colors.ROBOT_EDGE;
  context.stroke();
  context.restore();
}

/** How far a fan of the soft limit reaches on the floor (m). */
export const FAN_M = 1.6;

/** The directions in which the head follows a view alone; filled more while it looks past them and the base turns. */
export function drawSoftLimit(context: Context, view: MapView, place: Point, heading: number, limit: SoftLimit): void {
  const angle = screenAngle(view, heading);
  context.save();
  context.translate(place.x, place.y);
  context.beginPath();
  context.moveTo(0, 0);
  context.arc(0, 0, FAN_M * view.scale, angle - limit.angle, angle + limit.angle);
  context.closePath();
  context.fillStyle = limit.past ? colors.PAST_LIMIT : colors.WITHIN_LIMIT;
  context.fill();
  context.lineWidth = limit.past ? 2 : 1;
  context.strokeStyle = colors.AHEAD;
  context.stroke();
  context.restore();
}

/** The outline alone, dashed: of the body that will be, not of the one measured. */
export function drawAhead(context: Context, view: MapView, place: Point, pose: Pose, body: Body): void {
  const outline = body.footprint.length > 2 ? body.footprint : null;
  context.save();
  context.translate(place.x, place.y);
  context.rotate(screenAngle(view, pose.theta));
  if (outline)
    trace(
      context,
      outline.map(([x, y]) => ({ x: x * view.scale, y: -y * view.scale })),
      true,
    );
  else disc(context, { x: 0, y: 0 }, 0.3 * view.scale);
  context.lineWidth = 2;
  context.strokeStyle = colors.AHEAD;
  context.setLineDash([4, 3]);
  context.stroke();
  context.restore();
}

/** Twice the standard deviation: an ellipse of places, a fan of headings. */
function drawUnsure(context: Context, view: MapView, robot: Pose, sx: number, sy: number, st: number): void {
  const [rx, ry] = [2 * sx * view.scale, 2 * sy * view.scale];
  context.fillStyle = colors.UNSURE;
  if (Math.max(rx, ry) > 3) {
    context.beginPath();
    context.ellipse(0, 0, rx, ry, screenAngle(view, 0), 0, 2 * Math.PI);
    context.fill();
  }
  const half = Math.min(Math.PI, 2 * st);
  if (half < 0.05) return;
  const angle = screenAngle(view, robot.theta);
  context.beginPath();
  context.moveTo(0, 0);
  context.arc(0, 0, 34, angle - half, angle + half);
  context.closePath();
  context.fill();
}

export function drawGoal(context: Context, place: Point, heading: number | null, opacity: number): void {
  context.save();
  context.globalAlpha = opacity;
  context.translate(place.x, place.y);
  context.lineJoin = "round";
  if (heading !== null) drawArrow(context, heading);
  for (const [edge, color] of [
    [true, "#0b0f15"],
    [false, colors.GOAL],
  ] as const) {
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = edge ? 5 : 2;
    disc(context, { x: 0, y: 0 }, 4.5);
    context.stroke();
    context.beginPath();
    stroke(context, { x: 0, y: -4 }, { x: 0, y: -26 });
    context.stroke();
    context.beginPath();
    context.moveTo(0, -26);
    context.lineTo(15, -20.5);
    context.lineTo(0, -15);
    context.closePath();
    context.fill();
    if (edge) context.stroke();
  }
  context.restore();
}

function drawArrow(context: Context, angle: number): void {
  context.save();
  context.rotate(angle);
  for (const [color, width] of [
    ["#0b0f15", 6],
    [colors.GOAL, 3],
  ] as const) {
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = width;
    context.beginPath();
    stroke(context, { x: 6, y: 0 }, { x: 26, y: 0 });
    context.stroke();
    context.beginPath();
    context.moveTo(36, 0);
    context.lineTo(25, 6);
    context.lineTo(25, -6);
    context.closePath();
    if (width === 6) context.stroke();
    context.fill();
  }
  context.restore();
}

export function drawTarget(context: Context, target: Point, goal: Point): void {
  context.strokeStyle = colors.GOAL;
  context.lineWidth = 2;
  context.setLineDash([3, 4]);
  context.beginPath();
  stroke(context, target, goal);
  context.stroke();
  context.setLineDash([]);
  disc(context, target, 6);
  context.stroke();
}

/** What a hand is about to set: a goal, or where the robot is. */
export function drawAim(
  context: Context,
  view: MapView,
  place: Point,
  heading: number | null,
  robot: (Body & { theta: number }) | null,
): void {
  if (!robot) {
    drawGoal(context, place, headingOf(view, heading), 0.9);
    return;
  }
  const pose = { x: 0, y: 0, theta: heading ?? robot.theta };
  drawRobot(context, view, place, pose, { ...robot, sigma: [0, 0, 0], astray: false });
  if (heading === null) return;
  context.save();
  context.translate(place.x, place.y);
  drawArrow(context, screenAngle(view, heading));
  context.restore();
}

export function drawStart(context: Context, { x, y }: Point): void {
  context.strokeStyle = "#93a4ba";
  context.lineWidth = 1.5;
  context.beginPath();
  stroke(context, { x: x - 6, y }, { x: x + 6, y });
  stroke(context, { x, y: y - 6 }, { x, y: y + 6 });
  context.stroke();
  disc(context, { x, y }, 3.5);
  context.stroke();
}

/** A dot with an arrow to where one stands there looking; `doubtful`: only its outline. */
export function drawPlace(context: Context, at: Point, angle: number, doubtful: boolean): void {
  context.save();
  context.translate(at.x, at.y);
  context.rotate(angle);
  context.lineJoin = "round";
  for (const [color, width] of [
    ["#0b0f15", 5],
    [colors.PLACE, 2],
  ] as const) {
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = width;
    context.beginPath();
    context.arc(0, 0, 6, 0.5, 2 * Math.PI - 0.5);
    context.lineTo(14, 0);
    context.closePath();
    context.stroke();
  }
  if (!doubtful) context.fill();
  context.restore();
}

/** Names below their places; one that would lie on another's is left out until there is room for it. */
export function drawPlaceNames(context: Context, named: readonly { at: Point; name: string }[]): void {
  context.font = `600 11.5px ${FONT}`;
  context.textAlign = "center";
  context.textBaseline = "top";
  const drawn: { x: number; y: number; half: number }[] = [];
  for (const { at, name } of named) {
    const shown = name.length > LONGEST ? `${name.slice(0, LONGEST - 1)}…` : name;
    const half = context.measureText(shown).width / 2;
    const covers = drawn.some(({ x, y, half: other }) => Math.abs(x - at.x) < half + other && Math.abs(y - at.y) < 13);
    if (covers) continue;
    drawn.push({ ...at, half });
    outlined(context, shown, at.x, at.y + 10, colors.PLACE);
  }
}

export function drawPoster(context: Context, { x, y }: Point): void {
  context.fillStyle = colors.POSTER;
  context.fillRect(x - 3, y - 4, 6, 8);
  context.strokeStyle = "#0b0f15";
  context.lineWidth = 1;
  context.strokeRect(x - 3, y - 4, 6, 8);
}

export function drawPerson(context: Context, place: Point): void {
  disc(context, place, 5.5);
  context.fillStyle = "#0b0f15";
  context.fill();
  context.lineWidth = 2.5;
  context.strokeStyle = colors.PERSON;
  context.stroke();
}

/** A person by name: filled while speaking, faint while lost. */
export function drawNamedPerson(
  context: Context,
  { x, y }: Point,
  name: string,
  { speaking, state }: { speaking: boolean; state: string },
): void {
  context.globalAlpha = state === "lost" ? 0.45 : 1;
  disc(context, { x, y }, 6.5);
  context.fillStyle = speaking ? colors.PERSON : "#0b0f15";
  context.fill();
  context.lineWidth = 2.5;
  context.strokeStyle = colors.PERSON;
  context.stroke();
  context.font = "600 11px system-ui, 'DejaVu Sans', sans-serif";
  context.textAlign = "center";
  context.textBaseline = "bottom";
  const text = speaking ? t("{name}, speaking", { name }) : name;
  context.lineWidth = 3;
  context.strokeStyle = "rgb(0 0 0 / 0.7)";
  context.strokeText(text, x, y - 9);
  context.fillStyle = "#ffffff";
  context.fillText(text, x, y - 9);
  context.globalAlpha = 1;
}

export function drawCursor(context: Context, { x, y }: Point): void {
  for (const [color, width] of [
    ["#0b0f15", 4],
    ["#ffffff", 1.5],
  ] as const) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.beginPath();
    for (const [dx, dy] of [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ] as const)
      stroke(context, { x: x + 4 * dx, y: y + 4 * dy }, { x: x + 12 * dx, y: y + 12 * dy });
    context.stroke();
  }
}

export function headingOf(view: MapView, theta: number | null): number | null {
  return theta === null ? null : screenAngle(view, theta);
}
