import { expect, test } from "vitest";
import { BAND_DEG, type Follow, follow, SOFT_LIMIT_DEG, STILL } from "./viewFollow";
import examples from "./viewFollow.examples.json";

const STEP_S = 0.05;
/** Of the robot in its lab. */
const HEAD_DEGPS = 60;
const BASE_DEGPS = 57;

/** A head and a base that do at once what they are given, under a view at `view(t)` in the room. */
function played(view: (t: number) => number, seconds: number, limit = SOFT_LIMIT_DEG) {
  let [state, base, gaze]: [Follow, number, number] = [STILL, 0, 0];
  let travelled = 0;
  const speeds: number[] = [];
  for (let t = 0; t < seconds; t += STEP_S) {
    state = follow(state, { bearing: view(t) - base, gaze }, limit, STEP_S);
    const turned = state.angular * BASE_DEGPS * STEP_S;
    base += turned;
    travelled += Math.abs(turned);
    gaze = Math.max(-128, Math.min(128, gaze + state.pan * HEAD_DEGPS * STEP_S));
    speeds.push(state.angular);
  }
  return { base, gaze, travelled, speeds, state };
}

test.each([0.2, 0.5, 1, 2, 4])("a view that swings about the limit at %s Hz leaves the base where it is", (hertz) => {
  for (const swing of [1, 3, 5, 7]) {
    const noise = (t: number) => 0.4 * Math.sin(37 * t);
    const { travelled } = played((t) => SOFT_LIMIT_DEG + swing * Math.sin(2 * Math.PI * hertz * t) + noise(t), 30);
    expect(travelled).toBeLessThan(2);
  }
});

test("on the other side, too, and at another limit", () => {
  const { travelled } = played((t) => -45 + 4 * Math.sin(6 * t), 30, 45);
  expect(travelled).toBeLessThan(2);
});

test("within the limit the head follows alone", () => {
  const { base, gaze } = played((t) => Math.min(25, 40 * t), 3);
  expect(base).toBe(0);
  expect(Math.abs(gaze - 25)).toBeLessThan(2);
});

test("far beyond it the base turns after the view until the limit, slowly at first, and stands", () => {
  const { base, state, speeds } = played(() => 100, 12);
  expect(100 - base).toBeGreaterThan(SOFT_LIMIT_DEG - 1);
  expect(100 - base).toBeLessThan(SOFT_LIMIT_DEG + BAND_DEG);
  expect(Math.abs(state.angular)).toBeLessThan(0.05);
  expect(Math.abs(speeds[0]!)).toBeLessThan(0.1);
  const jumps = speeds.slice(1).map((speed, k) => Math.abs(speed) - Math.abs(speeds[k]!));
  expect(Math.max(...jumps)).toBeLessThan(0.1);
});

test("a view brought back ends the turn at once", () => {
  const turning: Follow = { turning: true, pan: 0, angular: 0.5 };
  expect(follow(turning, { bearing: 10, gaze: 10 }, SOFT_LIMIT_DEG, STEP_S)).toEqual(STILL);
  expect(follow(turning, { bearing: -60, gaze: -60 }, SOFT_LIMIT_DEG, STEP_S).angular).toBe(0);
});

test("what is no angle moves nothing", () => {
  expect(follow({ ...STILL, turning: true }, { bearing: Number.NaN, gaze: 0 }, SOFT_LIMIT_DEG, STEP_S)).toEqual(STILL);
});

test.each(examples)(
  "as the pursuit study's operator does: $name",
  ({ before, bearing, gaze, limit, passed, after }) => {
    const found = follow(before, { bearing, gaze }, limit, passed);
    expect(found.turning).toBe(after.turning);
    expect(found.pan).toBeCloseTo(after.pan, 6);
    expect(found.angular).toBeCloseTo(after.angular, 6);
  },
);
