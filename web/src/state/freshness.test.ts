import { expect, test } from "vitest";
import { isFresh } from "./freshness";

test("a robot is judged by its status alone: pongs do not make an old view fresh", () => {
  expect(isFresh({ status: 400, anything: 400 }, false)).toBe(true);
  expect(isFresh({ status: 600, anything: 10 }, false)).toBe(false);
});

test("a paused recording is not stale while it answers", () => {
  expect(isFresh({ status: 60_000, anything: 900 }, true)).toBe(true);
  expect(isFresh({ status: 60_000, anything: 3000 }, true)).toBe(false);
});
