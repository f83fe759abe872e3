/** Draws the map from above: cells, zones, the way, the robot, and what hands are about to do. */

import type { Zone } from "../protocol/types";
import { lengthWords } from "./words";
import * as colors from "./colors";
import type { GridPicture } from "./feed";
import type { Act, Tool } from "./hands";
import { composed, matrix, type MapView, NORTH, type Point, type Pose, scaleBar, screenAngle, type Size, toScreen } from "./projection";
import { cornersOf, middle } from "./zoneList";

export interface Shown {
  map: GridPicture | null;
  costmap: GridPicture | null;
  X_MO: Pose | null;
  robot: Pose | null;
  /** Standard deviations of the robot's pose: x, y (m), theta (rad). */
  sigma: readonly [number, number, number];
  /** It does not know where it is: where it was last is drawn faintly. */
  astray: boolean;
  footprint: readonly (readonly [number, number])[];
  path: readonly (readonly [number, number])[];
  goal: (Point & { theta: number | null }) | null;
  target: Point | null;
  zones: readonly Zone[];
  selected: string | null;
  tool: Tool;
  act: Act;
  /** Of the zone that is being drawn. */
  sketch: readonly Point[];
  cursor: Point | null;
  /** Over all of the view: its lower corners are under the drive pad and the view's tools. */
  roomy: boolean;
  people: readonly Point[];
  posters: readonly (Point & { text: string })[];
}

type Context = CanvasRenderingContext2D;
const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif";
const BAR_PX = 110;
/** The robot is never drawn smaller. */
const LEAST_ROBOT_PX = 9;
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
  if (shown.costmap) drawGrid(context, size, view, shown.costmap, shown.costmap.info.frame === "map" ? null : shown.X_MO, density);
  plain();
  for (const zone of shown.zones) drawZone(context, moving(zone, shown.act), at, zone.name === shown.selected);
  if (shown.sketch.length > 0) drawSketch(context, shown.sketch.map(at), shown.tool === "slow" ? colors.SLOW : colors.KEEP_OUT);
  drawStart(context, at({ x: 0, y: 0 }));
  for (const poster of shown.posters) drawPoster(context, at(poster));
  drawPath(context, shown.path.map(([x, y]) => at({ x, y })));
  for (const person of shown.people) drawPerson(context, at(person));
  if (shown.robot) drawRobot(context, view, at(shown.robot), shown.robot, shown);
  if (shown.target && shown.goal && Math.hypot(shown.target.x - shown.goal.x, shown.target.y - shown.goal.y) > 0.1)
    drawTarget(context, at(shown.target), at(shown.goal));
  if (shown.goal) drawGoal(context, at(shown.goal), headingOf(view, shown.goal.theta), 1);
  if (shown.act.kind === "aim") drawAim(context, view, at(shown.act.place), shown.act.heading, shown);
  if (shown.cursor) drawCursor(context, at(shown.cursor));
  drawBar(context, size, view, shown.roomy);
  if (Math.abs(view.up - NORTH) > 1e-3) drawNorth(context, view, { x: size.width - 62, y: 28 });
}

function drawGrid(context: Context, size: Size, view: MapView, { info, canvas }: GridPicture, X_MF: Pose | null, density: number): void {
  if (info.frame !== "map" && !X_MF) return;
  const [a, b, c, d, e, f] = matrix(view, size);
  context.setTransform(density * a, density * b, density * c, density * d, density * e, density * f);
  if (X_MF) {
    const { x, y, theta } = composed(X_MF, { x: 0, y: 0, theta: 0 });
    context.transform(Math.cos(theta), Math.sin(theta), -Math.sin(theta), Math.cos(theta), x, y);
  }
  // Cells are told apart from near; from far they are averaged.
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
    stroke(context, toScreen(view, size, { x: line, y: view.y - reach }), toScreen(view, size, { x: line, y: view.y + reach }));
  for (let line = Math.ceil((view.y - reach) / every) * every; line <= view.y + reach; line += every)
    stroke(context, toScreen(view, size, { x: view.x - reach, y: line }), toScreen(view, size, { x: view.x + reach, y: line }));
  context.stroke();
}

/** While its corner is being dragged, as it would be. */
function moving(zone: Zone, act: Act): Zone {
  if (act.kind !== "corner" || act.handle.zone !== zone.name) return zone;
  const polygon = zone.polygon.map((corner, i): [number, number] => (i === act.handle.index ? [act.to.x, act.to.y] : corner));
  return { ...zone, polygon };
}

function drawZone(context: Context, zone: Zone, at: (point: Point) => Point, selected: boolean): void {
  const corners = cornersOf(zone).map(at);
  const color = zone.kind === "slow" ? colors.SLOW : colors.KEEP_OUT;
  trace(context, corners, true);
  context.fillStyle = pattern(context, zone.kind);
  context.fill();
  context.lineWidth = selected ? 3 : 1.75;
  context.strokeStyle = color;
  context.setLineDash(zone.kind === "slow" ? [7, 4] : []);
  context.stroke();
  context.setLineDash([]);
  if (selected) for (const corner of corners) drawHandle(context, corner, color);
  const wide = Math.max(...corners.map(({ x }) => x)) - Math.min(...corners.map(({ x }) => x));
  const text = zone.kind === "slow" ? `${zone.name} · ${Math.round(zone.speed * 100)} %` : zone.name;
  context.font = `600 11.5px ${FONT}`;
  if (selected || context.measureText(text).width < wide + 16) drawLabel(context, at(middle(zone)), text, color);
}

/** Keep-out is hatched, slow is dotted: told apart without their colours. */
function pattern(context: Context, kind: Zone["kind"]): CanvasPattern | string {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 10;
  const pen = tile.getContext("2d")!;
  if (kind === "slow") {
    pen.fillStyle = "rgb(240 228 66 / 0.1)";
    pen.fillRect(0, 0, 10, 10);
    pen.fillStyle = "rgb(240 228 66 / 0.65)";
    disc(pen, { x: 3, y: 3 }, 1.3);
    pen.fill();
  } else {
    pen.fillStyle = "rgb(255 138 76 / 0.16)";
    pen.fillRect(0, 0, 10, 10);
    pen.strokeStyle = "rgb(255 138 76 / 0.75)";
    pen.lineWidth = 1.6;
    pen.beginPath();
    for (const off of [-10, 0, 10]) stroke(pen, { x: off, y: 10 }, { x: off + 10, y: 0 });
    pen.stroke();
  }
  return context.createPattern(tile, "repeat") ?? "rgb(255 255 255 / 0.15)";
}

function drawSketch(context: Context, corners: Point[], color: string): void {
  trace(context, corners, corners.length > 2);
  context.fillStyle = "rgb(255 255 255 / 0.12)";
  if (corners.length > 2) context.fill();
  context.lineWidth = 2;
  context.strokeStyle = color;
  context.setLineDash([4, 4]);
  context.stroke();
  context.setLineDash([]);
  for (const corner of corners) drawHandle(context, corner, color);
}

function drawHandle(context: Context, { x, y }: Point, color: string): void {
  context.fillStyle = "#0b0f15";
  context.strokeStyle = color;
  context.lineWidth = 2;
  context.beginPath();
  context.rect(x - 4.5, y - 4.5, 9, 9);
  context.fill();
  context.stroke();
}

function drawStart(context: Context, { x, y }: Point): void {
  context.strokeStyle = "#93a4ba";
  context.lineWidth = 1.5;
  context.beginPath();
  stroke(context, { x: x - 6, y }, { x: x + 6, y });
  stroke(context, { x, y: y - 6 }, { x, y: y + 6 });
  context.stroke();
  disc(context, { x, y }, 3.5);
  context.stroke();
}

function drawPoster(context: Context, { x, y }: Point): void {
  context.fillStyle = colors.POSTER;
  context.fillRect(x - 3, y - 4, 6, 8);
  context.strokeStyle = "#0b0f15";
  context.lineWidth = 1;
  context.strokeRect(x - 3, y - 4, 6, 8);
}

function drawPerson(context: Context, place: Point): void {
  disc(context, place, 5.5);
  context.fillStyle = "#0b0f15";
  context.fill();
  context.lineWidth = 2.5;
  context.strokeStyle = colors.PERSON;
  context.stroke();
}

function drawPath(context: Context, points: Point[]): void {
  if (points.length < 2) return;
  context.lineJoin = context.lineCap = "round";
  for (const [color, width] of [["rgb(0 0 0 / 0.65)", 6], [colors.PATH, 3]] as const) {
    trace(context, points, false);
    context.lineWidth = width;
    context.strokeStyle = color;
    context.stroke();
  }
  context.lineCap = "butt";
}

function drawRobot(context: Context, view: MapView, place: Point, robot: Pose, shown: Shown): void {
  const [sx, sy, st] = shown.sigma;
  context.save();
  context.translate(place.x, place.y);
  if (shown.astray) context.globalAlpha = 0.45;
  else drawUnsure(context, view, robot, sx, sy, st);
  context.rotate(screenAngle(view, robot.theta));
  const outline = shown.footprint.length > 2 ? shown.footprint : null;
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

function drawGoal(context: Context, place: Point, heading: number | null, opacity: number): void {
  context.save();
  context.globalAlpha = opacity;
  context.translate(place.x, place.y);
  context.lineJoin = "round";
  if (heading !== null) drawArrow(context, heading);
  for (const [edge, color] of [[true, "#0b0f15"], [false, colors.GOAL]] as const) {
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
  for (const [color, width] of [["#0b0f15", 6], [colors.GOAL, 3]] as const) {
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

function drawTarget(context: Context, target: Point, goal: Point): void {
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

function drawAim(context: Context, view: MapView, place: Point, heading: number | null, shown: Shown): void {
  if (shown.tool !== "pose") {
    drawGoal(context, place, headingOf(view, heading), 0.9);
    return;
  }
  const pose = { x: 0, y: 0, theta: heading ?? shown.robot?.theta ?? 0 };
  drawRobot(context, view, place, pose, { ...shown, sigma: [0, 0, 0], astray: false });
  if (heading !== null) {
    context.save();
    context.translate(place.x, place.y);
    drawArrow(context, screenAngle(view, heading));
    context.restore();
  }
}

function drawCursor(context: Context, { x, y }: Point): void {
  for (const [color, width] of [["#0b0f15", 4], ["#ffffff", 1.5]] as const) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const)
      stroke(context, { x: x + 4 * dx, y: y + 4 * dy }, { x: x + 12 * dx, y: y + 12 * dy });
    context.stroke();
  }
}

function drawBar(context: Context, size: Size, view: MapView, roomy: boolean): void {
  const { metres, px } = scaleBar(view.scale, BAR_PX);
  const [left, bottom] = roomy ? [size.width - px - 14, size.height - 60] : [12, size.height - 12];
  for (const [color, width] of [["rgb(10 13 18 / 0.85)", 5], ["#c3cedb", 2]] as const) {
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

function drawLabel(context: Context, { x, y }: Point, text: string, color: string): void {
  context.font = `600 11.5px ${FONT}`;
  const width = context.measureText(text).width + 10;
  context.fillStyle = "rgb(10 13 18 / 0.82)";
  context.beginPath();
  context.roundRect(x - width / 2, y - 9, width, 18, 5);
  context.fill();
  context.fillStyle = color;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, x, y + 0.5);
}

function outlined(context: Context, text: string, x: number, y: number, color: string): void {
  context.lineJoin = "round";
  context.lineWidth = 3.5;
  context.strokeStyle = "rgb(10 13 18 / 0.9)";
  context.strokeText(text, x, y);
  context.fillStyle = color;
  context.fillText(text, x, y);
}

function headingOf(view: MapView, theta: number | null): number | null {
  return theta === null ? null : screenAngle(view, theta);
}

function trace(context: Context, points: readonly Point[], closed: boolean): void {
  context.beginPath();
  points.forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (closed) context.closePath();
}

function stroke(context: Context, from: Point, to: Point): void {
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
}

function disc(context: Context, { x, y }: Point, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}
