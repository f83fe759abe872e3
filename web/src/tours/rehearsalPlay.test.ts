import { expect, test } from "vitest";
import type { Rehearsal } from "../protocol/types";
import { markAt, problemsByStop, progressWords, resultWords, saidAt, speedOf, stateAt } from "./rehearsalPlay";
import { aRehearsal, aRehearsalReport } from "./tourRun.fixture";

const pose = (at_s: number, x: number, heading = 0) => ({ at_s, x, y: 0, heading, farthest_m: null });
const MOVES: Rehearsal = aRehearsal({ path: [pose(0, 0), pose(2, 1, Math.PI - 0.1), pose(4, 3, -Math.PI + 0.1)] });

test("the mark goes along the way, turns the short way round, and leaves its trail", () => {
  expect(markAt(MOVES, 1)).toMatchObject({ x: 0.5, y: 0 });
  const late = markAt(MOVES, 3)!;
  expect(late.x).toBe(2);
  expect(Math.cos(late.theta)).toBeCloseTo(-1);
  expect(late.trail.map(({ x }) => x)).toEqual([0, 1, 2]);
  expect(markAt(MOVES, -1)?.x).toBe(0);
  expect(markAt(MOVES, 99)?.x).toBe(3);
  expect(markAt(aRehearsal({ path: [] }), 1)).toBeNull();
});

test("what is said and done at a moment", () => {
  const found = aRehearsal({
    subtitles: [{ at_s: 3, until_s: 5, text: "Hello.", language: "en" }],
    states: [
      { at_s: 1, state: "inviting", stop: "", reason: "" },
      { at_s: 6, state: "leading", stop: "arm", reason: "" },
    ],
  });
  expect([2, 3, 4.9, 5].map((at) => saidAt(found, at))).toEqual(["", "Hello.", "Hello.", ""]);
  expect([0, 1, 7].map((at) => stateAt(found, at)?.state)).toEqual([undefined, "inviting", "leading"]);
});

test("it is played at least ten times faster than life, a long one within a minute", () => {
  expect(speedOf(aRehearsal({ duration_s: 100 }))).toBeGreaterThanOrEqual(10);
  expect(1800 / speedOf(aRehearsal({ duration_s: 1800 }))).toBeLessThanOrEqual(60);
});

test("problems stand with their stops", () => {
  const found = problemsByStop(
    aRehearsal({
      problems: [
        { severity: "error", stop: "arm", message: "not reached", at_s: 4 },
        { severity: "warning", stop: "", message: "a module failed", at_s: null },
        { severity: "warning", stop: "arm", message: "far", at_s: null },
      ],
    }),
  );
  expect([...found].map(([stop, problems]) => [stop, problems.length])).toEqual([
    ["arm", 2],
    ["", 1],
  ]);
});

test("a rehearsal in a line", () => {
  expect(resultWords(aRehearsal())).toBe("1:44 min, 12 m, 1 stop presented: the tour is over.");
  expect(progressWords(aRehearsalReport())).toBe("Getting ready…");
  expect(progressWords(aRehearsalReport({ seconds: 65, stop: "arm" }))).toContain("1:05 min played");
});
