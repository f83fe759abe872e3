/** Draws the map from above: cells, zones, the way, the robot, and what the tool in use is about to do. */

import type { SoftLimit } from "../drive/viewFollow";
import type { Zone } from "../protocol/types";
import { type Context, FONT, outlined, stroke, trace } from "./canvas";
import * as colors from "./colors";
import {
  type Body,
  drawAhead,
  drawAim,
  drawCursor,
  drawGoal,
  drawRobot,
  drawSoftLimit,
  drawStart,
  drawTarget,
  headingOf,
} from "./drawMarks";
import { drawSketch, drawZone, moving } from "./drawZones";
import type { GridPicture } from "./gridFeed";
import {
  composed,
  type MapView,
  matrix,
  NORTH,
  type Point,
  type Pose,
  type Size,
  scaleBar,
  screenAngle,
  toScreen,
} from "./mapProjection";
import { lengthWords } from "./mapText";
import type { Act, Tool } from "./mapTools";

export interface Shown {
  map: GridPicture | null;
  costmap: GridPicture | null;
  X_MO: Pose | null;
  robot: Pose | null;
  /** Where it will be when a command given now arrives; null: there. */
  ahead: Pose | null;
  body: Body;
  /** Of the head that follows the view, around the robot's heading; null: it does not. */
  softLimit: SoftLimit | null;
  path: readonly (readonly [number, number])[];
  goal: (Point & { theta: number | null }) | null;
  /** Where it does not go any more. */
  givenUp: (Point & { theta: number | null }) | null;
  target: Point | null;
  zones: readonly Zone[];
  selected: string | null;
  tool: Tool;
  act: Act;
  /** Of the zone that is being drawn. */
  sketch: readonly Point[];
  cursor: Point | null;
  /** How far from the right and the bottom the scale bar is, px; null: in the lower left corner. */
  bar: { right: number; bottom: number } | null;
  /** Draws what is perceived. `onScreen`: a place on the map (m) in px. */
  percepts: (context: Context, onScreen: (place: Point) => Point) => void;
}

const BAR_PX = 110;
const GRID_M = [1, 2, 5, 10, 20, 50];
const GRID_PX = 44;

export function draw(context: Context, size: Size, view: MapView, shown: Shown): void {
  const density = context.canvas.width / size.width;
  const plain = () => context.setTransform(density, 0, 0, density, 0, 0);
  const at = (point: Point) => toScreen(view, size, point);
  plain();
  context.fillStyle = colors.UNKNOWN;
  context.fillRect(0, 0, size.width, size.height);
  if (shown.map) drawGrid(context, size, view, shown.map, null, density);
  plain();
  drawLines(context, size, view);
  if (shown.costmap)
    drawGrid(context, size, view, shown.costmap, shown.costmap.info.frame === "map" ? null : shown.X_MO, density);
  plain();
  for (const zone of shown.zones) drawZone(context, moving(zone, shown.act), at, zone.name === shown.selected);
  if (shown.sketch.length > 0)
    drawSketch(context, shown.sketch.map(at), shown.tool === "slow" ? colors.SLOW : colors.KEEP_OUT);
  if (shown.map?.known) drawStart(context, at({ x: 0, y: 0 }));
  drawPath(
    context,
    shown.path.map(([x, y]) => at({ x, y })),
  );
  shown.percepts(context, at);
  if (shown.ahead) drawAhead(context, view, at(shown.ahead), shown.ahead, shown.body);
  if (shown.robot && shown.softLimit) drawSoftLimit(context, view, at(shown.robot), shown.robot.theta, shown.softLimit);
  if (shown.robot) drawRobot(context, view, at(shown.robot), shown.robot, shown.body);
  if (shown.target && shown.goal && Math.hypot(shown.target.x - shown.goal.x, shown.target.y - shown.goal.y) > 0.1)
    drawTarget(context, at(shown.target), at(shown.goal));
  if (shown.givenUp) drawGoal(context, at(shown.givenUp), headingOf(view, shown.givenUp.theta), 0.45);
  if (shown.goal) drawGoal(context, at(shown.goal), headingOf(view, shown.goal.theta), 1);
  if (shown.act.kind === "aim") {
    const placed = shown.tool === "pose" ? { ...shown.body, theta: shown.robot?.theta ?? 0 } : null;
    drawAim(context, view, at(shown.act.place), shown.act.heading, placed);
  }
  if (shown.cursor) drawCursor(context, at(shown.cursor));
  drawBar(context, size, view, shown.bar);
  if (Math.abs(view.up - NORTH) > 1e-3) drawNorth(context, view, { x: size.width - 62, y: 28 });
}

function drawGrid(
  context: Context,
  size: Size,
  view: MapView,
  { info, canvas }: GridPicture,
  X_MF: Pose | null,
  density: number,
): void {
  if (info.frame !== "map" && !X_MF) return;
  const [a, b, c, d, e, f] = matrix(view, size);
  context.setTransform(density * a, density * b, density * c, density * d, density * e, density * f);
  if (X_MF) {
    const { x, y, theta } = composed(X_MF, { x: 0, y: 0, theta: 0 });
    context.transform(Math.cos(theta), Math.sin(theta), -Math.sin(theta), Math.cos(theta), x, y);
  }
  // Cells are sharp from near; from far they are averaged.
  context.imageSmoothingEnabled = view.scale * info.resolution_m * density < 2;
  const [x, y] = info.origin;
  context.translate(x, y + canvas.height * info.resolution_m);
  context.scale(info.resolution_m, -info.resolution_m);
  context.drawImage(canvas, 0, 0);
}

/** Every so many whole metres, to judge lengths by. */
function drawLines(context: Context, size: Size, view: MapView): void {
  const every = GRID_M.find((metres) => metres * view.scale >= GRID_PX) ?? 100;
  const reach = Math.hypot(size.width, size.height) / 2 / view.scale;
  context.strokeStyle = "rgb(140 165 200 / 0.13)";
  context.lineWidth = 1;
  context.beginPath();
  for (let line = Math.ceil((view.x - reach) / every) * every; line <= view.x + reach; line += every)
    stroke(
      context,
      toScreen(view, size, { x: line, y: view.y - reach }),
      toScreen(view, size, { x: line, y: view.y + reach }),
    );
  for (let line = Math.ceil((view.y - reach) / every) * every; line <= view.y + reach; line += every)
    stroke(
      context,
      toScreen(view, size, { x: view.x - reach, y: line }),
      toScreen(view, size, { x: view.x + reach, y: line }),
    );
  context.stroke();
}

function drawPath(context: Context, points: Point[]): void {
  if (points.length < 2) return;
  context.lineJoin = context.lineCap = "round";
  for (const [color, width] of [
    ["rgb(0 0 0 / 0.65)", 6],
    [colors.PATH, 3],
  ] as const) {
    trace(context, points, false);
    context.lineWidth = width;
    context.strokeStyle = color;
    context.stroke();
  }
  context.lineCap = "butt";
}

function drawBar(context: Context, size: Size, view: MapView, bar: Shown["bar"]): void {
  const { metres, px } = scaleBar(view.scale, BAR_PX);
  const [left, bottom] = bar ? [size.width - px - bar.right, size.height - bar.bottom] : [12, size.height - 12];
  for (const [color, width] of [
    ["rgb(10 13 18 / 0.85)", 5],
    ["#c3cedb", 2],
  ] as const) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.beginPath();
    context.moveTo(left, bottom - 6);
    context.lineTo(left, bottom);
    context.lineTo(left + px, bottom);
    context.lineTo(left + px, bottom - 6);
    context.stroke();
  }
  context.font = `600 11.5px ${FONT}`;
  context.textAlign = "left";
  context.textBaseline = "bottom";
  outlined(context, lengthWords(metres), left + 6, bottom - 3, "#e9eef5");
}

/** Where north is while something else is up. */
function drawNorth(context: Context, view: MapView, { x, y }: Point): void {
  context.save();
  context.translate(x, y);
  context.rotate(screenAngle(view, NORTH) + Math.PI / 2);
  context.beginPath();
  context.moveTo(0, -15);
  context.lineTo(6, 3);
  context.lineTo(0, 0);
  context.lineTo(-6, 3);
  context.closePath();
  context.fillStyle = "#e9eef5";
  context.strokeStyle = "#0b0f15";
  context.lineWidth = 2;
  context.stroke();
  context.fill();
  context.font = `700 11px ${FONT}`;
  context.textAlign = "center";
  context.textBaseline = "top";
  outlined(context, "N", 0, 5, "#e9eef5");
  context.restore();
}
