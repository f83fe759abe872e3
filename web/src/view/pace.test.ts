import { expect, test } from "vitest";
import { FULL, hopeless, paced, SHARES } from "./pace";

function run(frameMs: number, windows: number, from = FULL) {
  return Array.from({ length: windows }).reduce<typeof FULL>((pace) => paced(pace, frameMs), from);
}

test("a view that keeps pace is drawn in full", () => {
  expect(run(17, 30).step).toBe(0);
  expect(run(60, 30).step).toBe(0);
});

test("a slow one is drawn smaller after some seconds, then smaller still, and no further", () => {
  expect(run(160, 1).step).toBe(0);
  expect(run(160, 2).step).toBe(1);
  expect(run(160, 30).step).toBe(SHARES.length - 1);
});

test("slow at the smallest is hopeless, slow before it is not", () => {
  expect(hopeless(run(160, 2))).toBe(false);
  expect(hopeless(run(160, 30))).toBe(true);
  expect(hopeless(run(17, 5, run(160, 30)))).toBe(false);
});

test("one slow moment is nothing, and what was made smaller stays so", () => {
  expect(run(17, 5, run(500, 1)).step).toBe(0);
  expect(run(17, 30, run(160, 2)).step).toBe(1);
});
