import { expect, test } from "vitest";
import type { Context } from "./canvas";
import * as colors from "./colors";
import { drawPlaceNames, drawRobot, drawSoftLimit, FAN_M } from "./drawMarks";
import { FIRST_VIEW } from "./mapProjection";

/** A context that remembers the first path that is filled: the robot's body. */
function drawn(footprint: [number, number][], scale = 100) {
  const paths: { corners: [number, number][]; radius: number }[] = [];
  const remember: Record<string, unknown> = {
    beginPath: () => paths.push({ corners: [], radius: 0 }),
    moveTo: (x: number, y: number) => paths.at(-1)!.corners.push([x, y]),
    lineTo: (x: number, y: number) => paths.at(-1)!.corners.push([x, y]),
    arc: (_x: number, _y: number, radius: number) => (paths.at(-1)!.radius = radius),
  };
  const context = new Proxy(remember, { get: (known, name: string) => known[name] ?? (() => undefined) });
  const body = { footprint, sigma: [0, 0, 0] as const, astray: true };
  drawRobot(context as unknown as Context, { ...FIRST_VIEW, scale }, { x: 0, y: 0 }, { x: 0, y: 0, theta: 0 }, body);
  return paths[0]!;
}

test("the robot is drawn by its own outline: x ahead, y to the left, as large as it is", () => {
  const jackal: [number, number][] = [
    [0.21, 0.165],
    [-0.21, 0.165],
    [-0.21, -0.165],
    [0.21, -0.165],
  ];
  const { corners, radius } = drawn(jackal);
  expect(radius).toBe(0);
  expect(corners.map(([x, y]) => [Math.round(10 * x) / 10, Math.round(10 * y) / 10])).toEqual([
    [21, -16.5],
    [-21, -16.5],
    [-21, 16.5],
    [21, 16.5],
  ]);
});

test("seen from far it keeps its shape, and is drawn large enough to be seen", () => {
  const { corners } = drawn(
    [
      [0.2, 0.1],
      [-0.2, 0.1],
      [-0.2, -0.1],
      [0.2, -0.1],
    ],
    5,
  );
  expect(Math.hypot(...corners[0]!)).toBeCloseTo(9);
  expect(corners[0]![0] / -corners[0]![1]).toBeCloseTo(2);
});

test("a body without an outline is a disc", () => {
  expect(drawn([])).toEqual({ corners: [], radius: 30 });
});

test("names of places do not lie on each other", () => {
  const names: string[] = [];
  const known: Record<string, unknown> = {
    measureText: (text: string) => ({ width: 7 * text.length }),
    fillText: (text: string) => names.push(text),
  };
  const context = new Proxy(known, { get: (all, name: string) => all[name] ?? (() => undefined), set: () => true });
  drawPlaceNames(context as unknown as Context, [
    { at: { x: 100, y: 100 }, name: "Charging dock" },
    { at: { x: 130, y: 104 }, name: "Living room" },
    { at: { x: 130, y: 130 }, name: "Office" },
    { at: { x: 220, y: 100 }, name: "Robotics lab" },
  ]);
  expect(names).toEqual(["Charging dock", "Office", "Robotics lab"]);
});

test("the soft limit is a fan to either side of the robot's heading, and filled more while the head is past it", () => {
  const arcs: number[][] = [];
  const context: Record<string, unknown> = { arc: (...arc: number[]) => arcs.push(arc) };
  const drawn = new Proxy(context, { get: (known, name: string) => known[name] ?? (() => undefined) });
  const view = { ...FIRST_VIEW, scale: 50 };
  const fills = [false, true].map((past) => {
    drawSoftLimit(drawn as unknown as Context, view, { x: 9, y: 9 }, Math.PI / 2, { angle: Math.PI / 6, past });
    return context.fillStyle;
  });
  // North is up, and angles on the screen go clockwise: a robot that faces north looks to -90 degrees.
  const [x, y, radius, begin, end] = arcs[0]!;
  expect([x, y, radius]).toEqual([0, 0, FAN_M * 50]);
  expect(begin).toBeCloseTo(-Math.PI / 2 - Math.PI / 6);
  expect(end).toBeCloseTo(-Math.PI / 2 + Math.PI / 6);
  expect(fills).toEqual([colors.WITHIN_LIMIT, colors.PAST_LIMIT]);
});
