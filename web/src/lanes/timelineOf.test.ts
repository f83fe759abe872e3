import { expect, test } from "vitest";
import type { RobotEvent } from "../protocol/types";
import { exploitedSpells, folded, foldedWords, idleFor, intentionAt, intentionSteps } from "./timelineOf";

let id = 0;
const event = (kind: string, subject: string, stamp: number, data: object = {}) =>
  ({ id: ++id, kind, subject, stamp, text: `${subject} at ${stamp}`, data }) as unknown as RobotEvent;

test("a class is exploited while at least one behavior commands for it", () => {
  const go = (behavior: string, stamp: number, ...classes: string[]) =>
    event("exploitation", behavior, stamp, { exploited: classes.length > 0, classes });
  const spells = exploitedSpells([
    go("Follow", 1, "GoTo"),
    go("Teleop", 2, "GoTo", "Telepresence"),
    go("Follow", 3),
    event("stale", "imv", 3.5),
    go("Teleop", 4, "Telepresence"),
    go("Follow", 6, "GoTo"),
  ]);
  expect(spells.get("GoTo")).toEqual([
    { from: 1, to: 4 },
    { from: 6, to: Infinity },
  ]);
  expect(spells.get("Telepresence")).toEqual([{ from: 2, to: Infinity }]);
});

test("an intention holds until the next; before the first none is known", () => {
  const steps = intentionSteps([
    event("intention", "intention", 10, { omega: 8, use: { cpu: 20 }, strategies: ["slam-1"], proven: true }),
    event("desire", "SLAM", 11),
    event("intention", "intention", 12, { omega: 16, use: { cpu: 40 }, strategies: [], proven: true }),
  ]);
  expect(steps.map(({ stamp, omega }) => [stamp, omega])).toEqual([
    [10, 8],
    [12, 16],
  ]);
  expect(intentionAt(steps, 11.9)!.strategies).toEqual(["slam-1"]);
  expect(intentionAt(steps, 9)).toBeNull();
});

test("repeats of one kind and subject are one mark, others between them or not", () => {
  const marks = folded(
    [
      event("stale", "imv", 1),
      event("overload", "world", 2),
      event("stale", "imv", 3),
      event("stale", "imv", 4),
      event("stale", "imv", 30),
    ],
    5,
  );
  expect(marks.map(foldedWords)).toEqual(["imv stale 3×", "world overload", "imv stale"]);
  expect(marks[0]).toMatchObject({ from: 1, to: 4, text: "imv at 4" });
});

test("of the guard, the mark says the state that it is in", () => {
  expect(folded([event("guard", "stale_command", 1)], 5).map(foldedWords)).toEqual(["guard: stale command"]);
});

test("a class is idle from the end of its last spell on", () => {
  const spells = [
    { from: 1, to: 3 },
    { from: 5, to: Infinity },
  ];
  expect([0, 2, 4.5, 6].map((stamp) => idleFor(spells, stamp))).toEqual([null, null, 1.5, null]);
  expect(idleFor([], 3)).toBe(null);
});
