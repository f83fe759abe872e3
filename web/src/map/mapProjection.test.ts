import { describe, expect, test } from "vitest";
import {
  composed,
  FIRST_VIEW,
  fitted,
  matrix,
  NORTH,
  panned,
  scaleBar,
  screenAngle,
  toMap,
  toScreen,
  zoomed,
} from "./mapProjection";

const size = { width: 400, height: 300 };
const north = { ...FIRST_VIEW, x: 2, y: 1, scale: 20 };

test("north-up: east is right, north is up", () => {
  expect(toScreen(north, size, { x: 2, y: 1 })).toEqual({ x: 200, y: 150 });
  const { x, y } = toScreen(north, size, { x: 3, y: 3 });
  expect(x).toBeCloseTo(220);
  expect(y).toBeCloseTo(110);
});

test("robot-up: what is ahead of the robot is up, what is left of it is left", () => {
  const theta = 0.7;
  const view = { ...north, up: theta };
  const ahead = toScreen(view, size, { x: 2 + Math.cos(theta), y: 1 + Math.sin(theta) });
  expect(ahead.x).toBeCloseTo(200);
  expect(ahead.y).toBeCloseTo(130);
  const left = toScreen(view, size, { x: 2 - Math.sin(theta), y: 1 + Math.cos(theta) });
  expect(left.x).toBeCloseTo(180);
  expect(left.y).toBeCloseTo(150);
});

describe("whatever is up", () => {
  for (const up of [NORTH, 0, -2.2, 3]) {
    const view = { x: -3, y: 7, scale: 33, up };
    const point = { x: 1.3, y: 4.4 };
    const seen = toScreen(view, size, point);

    test(`${up}: there and back`, () => {
      const back = toMap(view, size, seen);
      expect(back.x).toBeCloseTo(point.x);
      expect(back.y).toBeCloseTo(point.y);
    });

    test(`${up}: pictures are drawn where points are`, () => {
      const [a, b, c, d, e, f] = matrix(view, size);
      expect(a * point.x + c * point.y + e).toBeCloseTo(seen.x);
      expect(b * point.x + d * point.y + f).toBeCloseTo(seen.y);
    });

    test(`${up}: a drag moves what is under the hand with it`, () => {
      const moved = toScreen(panned(view, 17, -31), size, point);
      expect(moved.x).toBeCloseTo(seen.x + 17);
      expect(moved.y).toBeCloseTo(seen.y - 31);
    });

    test(`${up}: zooming keeps what is under the pointer`, () => {
      const anchor = { x: 40, y: 270 };
      const kept = toMap(view, size, anchor);
      const next = zoomed(view, size, 1.7, anchor);
      expect(next.scale).toBeCloseTo(33 * 1.7);
      expect(toScreen(next, size, kept).x).toBeCloseTo(anchor.x);
      expect(toScreen(next, size, kept).y).toBeCloseTo(anchor.y);
    });

    test(`${up}: an arrow's angle is that of its ends`, () => {
      const theta = 1.1;
      const tip = toScreen(view, size, { x: point.x + Math.cos(theta), y: point.y + Math.sin(theta) });
      const angle = screenAngle(view, theta);
      expect(Math.cos(angle)).toBeCloseTo((tip.x - seen.x) / 33);
      expect(Math.sin(angle)).toBeCloseTo((tip.y - seen.y) / 33);
    });

    test(`${up}: all of what is to fit is on the screen, and not small`, () => {
      const bounds = { left: -4, right: 18, bottom: -2, top: 6 };
      const fit = fitted(view, size, bounds);
      const corners = [bounds.left, bounds.right].flatMap((x) =>
        [bounds.bottom, bounds.top].map((y) => toScreen(fit, size, { x, y })),
      );
      for (const { x, y } of corners) {
        expect(x).toBeGreaterThanOrEqual(0);
        expect(x).toBeLessThanOrEqual(400);
        expect(y).toBeGreaterThanOrEqual(0);
        expect(y).toBeLessThanOrEqual(300);
      }
      const wide = Math.max(...corners.map(({ x }) => x)) - Math.min(...corners.map(({ x }) => x));
      const high = Math.max(...corners.map(({ y }) => y)) - Math.min(...corners.map(({ y }) => y));
      expect(Math.max(wide / 400, high / 300)).toBeGreaterThan(0.85);
    });
  }
});

test("zooming ends somewhere", () => {
  expect(zoomed(north, size, 1e6).scale).toBe(zoomed(north, size, 1e9).scale);
  expect(zoomed(north, size, 1e-6).scale).toBeGreaterThan(0);
});

test.each([
  [28, 100, 2],
  [400, 100, 0.2],
  [1.5, 100, 50],
  [50, 100, 2],
])("at %d px/m, %d px have room for %d m", (scale, most, metres) => {
  const bar = scaleBar(scale, most);
  expect(bar.metres).toBeCloseTo(metres);
  expect(bar.px).toBeLessThanOrEqual(most + 1e-9);
});

test("a pose in odom is on the map where X_MO puts it", () => {
  const seen = composed({ x: 1, y: 2, theta: Math.PI / 2 }, { x: 3, y: 0, theta: Math.PI });
  expect(seen.x).toBeCloseTo(1);
  expect(seen.y).toBeCloseTo(5);
  expect(seen.theta).toBeCloseTo(-Math.PI / 2);
});
