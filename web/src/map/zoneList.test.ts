import { expect, test } from "vitest";
import type { Zone } from "../protocol/types";
import {
  added,
  asSpeed,
  changed,
  cornerMoved,
  edited,
  inside,
  middle,
  NO_HISTORY,
  nameProblem,
  polygonProblem,
  removed,
  same,
  undoable,
  undone,
  zoneAt,
} from "./zoneList";

const square = (x: number, y: number, side: number) => [
  { x, y },
  { x: x + side, y },
  { x: x + side, y: y + side },
  { x, y: y + side },
];
const bowTie = [
  { x: 0, y: 0 },
  { x: 2, y: 2 },
  { x: 2, y: 0 },
  { x: 0, y: 2 },
];

test("new zones get names that are free, and a speed that means something", () => {
  let zones = added([], "keep_out", square(0, 0, 1));
  zones = added(zones, "keep_out", square(3, 0, 1));
  zones = removed(zones, "Keep out 1");
  zones = added(zones, "keep_out", square(6, 0, 1));
  zones = added(zones, "slow", square(0, 3, 2));
  expect(zones.map(({ name }) => name)).toEqual(["Keep out 2", "Keep out 1", "Slow 1"]);
  expect(zones[2]!.speed).toBeGreaterThan(0);
  expect(zones[2]!.speed).toBeLessThan(1);
});

test("a hand is not finer than a centimetre", () => {
  const [zone] = added([], "slow", [
    { x: 0.123456, y: 1 },
    { x: 1, y: 1 },
    { x: 1, y: 2 },
  ]);
  expect(zone!.polygon[0]).toEqual([0.12, 1]);
});

test("changing and moving touch one zone alone", () => {
  const zones = added(added([], "slow", square(0, 0, 1)), "slow", square(3, 0, 1));
  const next = cornerMoved(changed(zones, "Slow 2", { name: "Kitchen", speed: 0.2 }), "Kitchen", 2, { x: 5, y: 5 });
  expect(next[0]).toEqual(zones[0]);
  expect(next[1]!.name).toBe("Kitchen");
  expect(next[1]!.polygon[2]).toEqual([5, 5]);
  expect(zones[1]!.polygon[2]).toEqual([4, 1]);
});

test("the topmost zone is found", () => {
  const zones = added(added([], "slow", square(0, 0, 3)), "keep_out", square(1, 1, 1));
  expect(zoneAt(zones, { x: 1.5, y: 1.5 })!.kind).toBe("keep_out");
  expect(zoneAt(zones, { x: 0.5, y: 0.5 })!.kind).toBe("slow");
  expect(zoneAt(zones, { x: 4, y: 4 })).toBeNull();
});

test("the inside of a polygon with a bay", () => {
  const bay = [
    { x: 0, y: 0 },
    { x: 4, y: 0 },
    { x: 4, y: 4 },
    { x: 2, y: 1 },
    { x: 0, y: 4 },
  ];
  expect(inside(bay, { x: 2, y: 0.5 })).toBe(true);
  expect(inside(bay, { x: 2, y: 3 })).toBe(false);
});

test("corners that are no zone", () => {
  expect(polygonProblem(square(0, 0, 1).slice(0, 2))).toMatch(/three corners/);
  expect(polygonProblem(square(0, 0, 0.05))).toMatch(/too small/);
  expect(
    polygonProblem([
      { x: 0, y: 0 },
      { x: 2, y: 2 },
      { x: 3, y: 1 },
      { x: 0, y: 2 },
    ]),
  ).toMatch(/crosses/);
  expect(polygonProblem(bowTie)).not.toBe("");
  expect(polygonProblem(square(0, 0, 1))).toBe("");
});

test("a name sits in the middle", () => {
  const [zone] = added([], "slow", square(2, 4, 2));
  expect(middle(zone!).x).toBeCloseTo(3);
  expect(middle(zone!).y).toBeCloseTo(5);
});

test("names that cannot be", () => {
  const zones = added(added([], "slow", square(0, 0, 1)), "slow", square(3, 0, 1));
  expect(nameProblem(zones, " ", "Slow 1")).not.toBe("");
  expect(nameProblem(zones, "Slow 2", "Slow 1")).not.toBe("");
  expect(nameProblem(zones, "Slow 1", "Slow 1")).toBe("");
});

test("speeds are in steps, and never nothing", () => {
  expect(asSpeed(0)).toBe(0.05);
  expect(asSpeed(0.33)).toBeCloseTo(0.35);
  expect(asSpeed(2)).toBe(1);
});

test("our edits are undone one after the other", () => {
  const first: Zone[] = [];
  const second = added(first, "slow", square(0, 0, 1));
  const third = removed(second, "Slow 1");
  let history = edited(edited(NO_HISTORY, first, second), second, third);
  expect(undoable(history, third)).toBe(second);
  history = undone(history);
  expect(undoable(history, second)).toBe(first);
  history = undone(history);
  expect(undoable(history, first)).toBeNull();
});

test("what others have done since is not undone", () => {
  const mine = added([], "slow", square(0, 0, 1));
  const history = edited(NO_HISTORY, [], mine);
  const theirs = added(mine, "keep_out", square(3, 3, 1));
  expect(undoable(history, theirs)).toBeNull();
  // Nor is it, once we have gone on from there.
  const further = edited(history, theirs, added(theirs, "slow", square(6, 6, 1)));
  expect(further.past).toEqual([theirs]);
});

test("lists are compared by what they say, as the robot may round", () => {
  const zones = added([], "slow", square(0, 0, 1));
  expect(same(zones, [{ ...zones[0]!, speed: zones[0]!.speed + 1e-9 }])).toBe(true);
  expect(same(zones, [{ ...zones[0]!, name: "x" }])).toBe(false);
});
