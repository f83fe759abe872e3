import { expect, test } from "vitest";
import { BEFORE_M, goalFor } from "./clickToGo";

test("a click on the floor is the goal, with any heading", () => {
  expect(goalFor({ x: 2, y: 1, z: 0.02 }, { x: 0, y: 0 })).toEqual({ x: 2, y: 1, heading: null });
});

test("before what stands up it stops, looking at it", () => {
  for (const [x, y] of [
    [3, 0],
    [0, -2.5],
    [-4, 3],
  ] as const) {
    const goal = goalFor({ x, y, z: 1.2 }, { x: 0, y: 0 })!;
    expect(Math.hypot(x - goal.x, y - goal.y)).toBeCloseTo(BEFORE_M, 2);
    expect(goal.heading).toBeCloseTo(Math.atan2(y - goal.y, x - goal.x), 2);
  }
});

test("what is nearer than that is no goal", () => {
  expect(goalFor({ x: 0.5, y: 0.3, z: 1 }, { x: 0, y: 0 })).toBeNull();
});
