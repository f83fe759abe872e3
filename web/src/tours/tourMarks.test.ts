import { expect, test } from "vitest";
import type { Context } from "../map/canvas";
import * as colors from "../map/colors";
import type { Place } from "../protocol/types";
import { drawTour, gaps } from "./tourMarks";
import type { Leg } from "./tourRoute";
import { aStop, aTour } from "./tours.fixture";

const place = (id: string) => ({ id }) as Place;
const leg = (stop: string | null, state: Leg["state"]): Leg => ({
  stop,
  state,
  reason: "",
  length_m: 0,
  duration_s: 0,
  path: [],
});
const PLACED = new Map(["a", "b", "dock"].map((id) => [id, place(id)]));
const ends = (found: [Place, Place][]) => found.map(([from, to]) => `${from.id} ${to.id}`);

test("a leg that cannot be driven joins the places that it is between", () => {
  const tour = aTour([aStop("a"), aStop("b")], { home: "dock" });
  expect(ends(gaps(tour, [leg("a", "none"), leg("b", "way"), leg(null, "none")], PLACED))).toEqual([
    "dock a",
    "b dock",
  ]);
});

test("without a home the first stop is where the way begins", () => {
  const tour = aTour([aStop("a"), aStop("gone"), aStop("b")]);
  expect(ends(gaps(tour, [leg("gone", "none"), leg("b", "none")], PLACED))).toEqual(["a b"]);
});

/** The lines of a drawing: colour, dashes, ends. */
function strokes(draw: (context: Context) => void): [color: string, dashes: number[], points: number[][]][] {
  const found: [string, number[], number[][]][] = [];
  let points: number[][] = [];
  let dashes: number[] = [];
  const context: Record<string, unknown> = {
    strokeStyle: "",
    beginPath: () => void (points = []),
    moveTo: (x: number, y: number) => void points.push([x, y]),
    lineTo: (x: number, y: number) => void points.push([x, y]),
    setLineDash: (wanted: number[]) => void (dashes = wanted),
    stroke: () => void (points.length > 0 && found.push([context["strokeStyle"] as string, dashes, points])),
  };
  const others = { get: (known: Record<string, unknown>, name: string) => known[name] ?? (() => undefined) };
  draw(new Proxy(context, others) as unknown as Context);
  return found;
}

test("the map has a leg that cannot be driven as a dashed red line, and the others as their way", () => {
  const places = [
    { id: "a", x: 0, y: 0 },
    { id: "b", x: 1, y: 2 },
    { id: "c", x: 3, y: 2 },
  ] as Place[];
  const legs = [
    leg("b", "none"),
    {
      ...leg("c", "way"),
      path: [
        [1, 2],
        [3, 2],
      ] as const,
    },
  ];
  const tour = aTour([aStop("a"), aStop("b"), aStop("c")]);
  const marks = { tour, legs, places, open: null, rehearsed: null };
  const lines = strokes((context) => drawTour(context, marks, ({ x, y }) => ({ x: 10 * x, y: 10 * y })));
  const [gap, ...others] = lines.filter(([color]) => color === colors.KEEP_OUT);
  expect(gap?.[1].length).toBe(2);
  expect(gap?.[2]).toEqual([
    [0, 0],
    [10, 20],
  ]);
  expect(others).toEqual([]);
  expect(lines.find(([color]) => color === colors.PLACE)).toEqual([
    colors.PLACE,
    [],
    [
      [10, 20],
      [30, 20],
    ],
  ]);
});
