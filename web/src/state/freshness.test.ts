import { expect, test } from "vitest";
import { isFresh, showsNow } from "./freshness";

test("a robot is judged by its status alone: pongs do not make an old view fresh", () => {
  expect(isFresh({ status: 400, anything: 400 }, false)).toBe(true);
  expect(isFresh({ status: 600, anything: 10 }, false)).toBe(false);
});

test("a paused recording is not stale while it answers", () => {
  expect(isFresh({ status: 60_000, anything: 900 }, true)).toBe(true);
  expect(isFresh({ status: 60_000, anything: 3000 }, true)).toBe(false);
});

test("what stood around long ago does not stand around now", () => {
  expect(showsNow(10, 11.9, 1)).toBe(true);
  expect(showsNow(10, 12.1, 1)).toBe(false);
  expect(showsNow(10, 12.1, 4), "time flies in this recording").toBe(true);
  expect(showsNow(10, null, 1), "the time is not known").toBe(true);
});
