import { expect, test } from "vitest";
import { around, freeOf } from "./fitting";
import { FIRST_VIEW, fitted, toScreen } from "./mapProjection";

const known = { left: -2, right: 6, bottom: -3, top: 3 };

test("the robot, its goal and the way are part of all of the map", () => {
  const points = [
    { x: 0, y: 0 },
    { x: 3.4, y: 5 },
    { x: -4, y: 1 },
  ];
  expect(around(known, points)).toEqual({ left: -4, right: 6, bottom: -3, top: 5 });
  expect(around(null, [{ x: 1, y: 2 }])).toEqual({ left: 1, right: 1, bottom: 2, top: 2 });
  expect(around(null, [])).toBeNull();
});

test("over the view nothing of it goes under the camera and the drive pad", () => {
  const size = { width: 1014, height: 460 };
  const free = freeOf("view", size, true);
  const view = fitted(FIRST_VIEW, size, known, free);
  for (const x of [known.left, known.right])
    for (const y of [known.bottom, known.top]) {
      const at = toScreen(view, size, { x, y });
      expect(at.x).toBeGreaterThanOrEqual(404);
      expect(at.x).toBeLessThanOrEqual(1014 - 48);
      expect(at.y).toBeGreaterThanOrEqual(126);
    }
  expect(freeOf("view", size, false).left).toBeLessThan(free.left);
  expect(freeOf("view", { width: 390, height: 500 }, true).left).toBe(14);
  expect(freeOf("tab", { width: 370, height: 400 }, true).left).toBe(14);
});
