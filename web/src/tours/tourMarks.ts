/** The open tour on the map: its way, leg by leg, its stops by their numbers, and what is pointed at. */

import { type Context, disc, FONT, outlined, stroke, trace } from "../map/canvas";
import * as colors from "../map/colors";
import type { Point } from "../map/mapProjection";
import type { Place, Stop, Tour } from "../protocol/types";
import type { RehearsedMark } from "./rehearsalPlay";
import type { Leg } from "./tourRoute";

export interface TourMarks {
  tour: Tour;
  legs: readonly Leg[];
  places: readonly Place[];
  /** Id of the stop whose form is open. */
  open: string | null;
  /** Where the robot is in the rehearsal that is shown; null: none is. */
  rehearsed: RehearsedMark | null;
}

/** `at`: a place on the map (m) in px. */
export function drawTour(context: Context, marks: TourMarks, at: (point: Point) => Point): void {
  const { tour, legs, places, open, rehearsed } = marks;
  const placed = new Map(places.map((place) => [place.id, place]));
  for (const leg of legs) drawLeg(context, leg, at);
  for (const [from, to] of gaps(tour, legs, placed)) drawGap(context, at(from), at(to));
  const shown = tour.stops.find((stop) => stop.id === open);
  const from = shown && placed.get(shown.place);
  if (shown && from) for (const point of pointsOf(shown)) drawPointed(context, at(from), at(point));
  tour.stops.forEach((stop, number) => {
    const place = placed.get(stop.place);
    if (place) drawNumber(context, at(place), number + 1, stop);
  });
  if (rehearsed) drawRehearsed(context, rehearsed, at);
}

/** Unlike the robot itself, which stands somewhere else meanwhile: a ring with a beak, and its way behind it. */
function drawRehearsed(context: Context, { x, y, theta, trail }: RehearsedMark, at: (point: Point) => Point): void {
  trace(context, trail.map(at), false);
  context.lineWidth = 2;
  context.strokeStyle = "#ffd479";
  context.stroke();
  const here = at({ x, y });
  const ahead = at({ x: x + 0.5 * Math.cos(theta), y: y + 0.5 * Math.sin(theta) });
  context.lineWidth = 4;
  context.beginPath();
  stroke(context, here, ahead);
  context.stroke();
  disc(context, here, 8);
  context.fillStyle = "#ffd479";
  context.fill();
  context.lineWidth = 2;
  context.strokeStyle = "#0b0f15";
  context.stroke();
}

/** Ends of the legs that cannot be driven, which have no path. */
export function gaps(tour: Tour, legs: readonly Leg[], placed: ReadonlyMap<string, Place>): [Place, Place][] {
  const placeOf = (stop: string | null) =>
    placed.get((stop === null ? tour.home : tour.stops.find(({ id }) => id === stop)?.place) ?? "");
  const found: [Place, Place][] = [];
  let last = placeOf(null) ?? placeOf(tour.stops.find((stop) => !stop.left_out && placed.has(stop.place))?.id ?? null);
  for (const { stop, state } of legs) {
    const to = placeOf(stop);
    if (!to) continue;
    if (state === "none" && last) found.push([last, to]);
    last = to;
  }
  return found;
}

/** What is pointed and looked at on the map. */
function pointsOf(stop: Stop): Point[] {
  return stop.do.flatMap(({ point, look }) =>
    [point, Array.isArray(look) ? look : null].flatMap((one) => (one ? [{ x: one[0], y: one[1] }] : [])),
  );
}

function drawLeg(context: Context, { path }: Leg, at: (point: Point) => Point): void {
  if (path.length < 2) return;
  context.lineJoin = context.lineCap = "round";
  for (const [color, width] of [
    ["rgb(0 0 0 / 0.6)", 5],
    [colors.PLACE, 2.5],
  ] as const) {
    trace(
      context,
      path.map(([x, y]) => at({ x, y })),
      false,
    );
    context.lineWidth = width;
    context.strokeStyle = color;
    context.stroke();
  }
  context.lineCap = "butt";
}

function drawGap(context: Context, from: Point, to: Point): void {
  context.setLineDash([6, 6]);
  context.strokeStyle = colors.KEEP_OUT;
  context.lineWidth = 2.5;
  context.beginPath();
  stroke(context, from, to);
  context.stroke();
  context.setLineDash([]);
}

function drawPointed(context: Context, from: Point, to: Point): void {
  context.setLineDash([2, 4]);
  context.strokeStyle = "#ffffff";
  context.lineWidth = 1.5;
  context.beginPath();
  stroke(context, from, to);
  context.stroke();
  context.setLineDash([]);
  disc(context, to, 4);
  context.fillStyle = "#ffffff";
  context.fill();
}

function drawNumber(context: Context, { x, y }: Point, number: number, { left_out }: Stop): void {
  disc(context, { x, y }, 9);
  context.fillStyle = left_out ? "#3a4554" : colors.PLACE;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = "#0b0f15";
  context.stroke();
  context.font = `700 12px ${FONT}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  outlined(context, String(number), x, y + 0.5, "#ffffff");
}
