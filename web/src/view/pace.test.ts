import { expect, test } from "vitest";
import { hopeless, paced, SHARES, startPace } from "./pace";

function run(frameMs: number, seconds: number, from = startPace(0)) {
  let pace = from;
  for (let now = pace.began; now <= from.began + seconds * 1000; now += frameMs) pace = paced(pace, now);
  return pace;
}

test("a page that keeps pace is drawn in full", () => {
  expect(run(17, 60).step).toBe(0);
  expect(run(60, 60).step).toBe(0);
});

test("a slow one is drawn smaller after some seconds, then smaller still, and no further", () => {
  expect(run(160, 3).step).toBe(0);
  expect(run(160, 5).step).toBe(1);
  expect(run(160, 60).step).toBe(SHARES.length - 1);
});

test("slow at the smallest is hopeless, slow before it is not", () => {
  expect(hopeless(run(160, 5))).toBe(false);
  expect(hopeless(run(160, 60))).toBe(true);
  expect(hopeless(run(17, 10, run(160, 60)))).toBe(false);
});

test("one slow moment is nothing, and what was made smaller stays so", () => {
  const hitch = run(17, 10, run(500, 2.5));
  expect(hitch.step).toBe(0);
  const small = run(160, 5);
  expect(run(17, 60, { ...small }).step).toBe(1);
});
