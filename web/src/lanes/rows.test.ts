import { expect, test } from "vitest";
import type { DesireClass, LaneRow } from "../protocol/types";
import { heightOfRows, laneRows, parted, sameRows } from "./rows";

test("what nothing serves has no lane, unless it is desired", () => {
  const rows = [
    { class: "SLAM", state: "undesired" },
    { class: "Record", state: "undesired" },
    { class: "LocateFaces", state: "unfulfilled" },
  ] as LaneRow[];
  const classes = [
    { name: "SLAM", served: true },
    { name: "Record", served: false },
    { name: "LocateFaces", served: false },
  ] as DesireClass[];
  expect(laneRows(rows, classes).map((row) => row.class)).toEqual(["SLAM", "LocateFaces"]);
});

test("rows are the same for people while rates differ by less than a percent", () => {
  const row = { class: "SLAM", state: "fulfilled", rate: 0.501, divisors: { "SLAM.scans": 2 } } as unknown as LaneRow;
  expect(sameRows([row], [{ ...row, rate: 0.504, divisors: { "SLAM.scans": 2 } }])).toBe(true);
  for (const other of [{ rate: 0.52 }, { state: "degraded" as const }, { divisors: { "SLAM.scans": 4 } }])
    expect(sameRows([row], [{ ...row, ...other }])).toBe(false);
  expect(sameRows([row], [])).toBe(false);
});

test("what nothing desires is folded, unless it was desired in the time that is seen", () => {
  const rows = [
    { class: "SLAM", state: "fulfilled" },
    { class: "Record", state: "undesired" },
    { class: "GoTo", state: "undesired" },
  ] as LaneRow[];
  const names = (all: boolean) => parted(rows, (name) => name === "GoTo", all).shown.map((row) => row.class);
  expect(names(false)).toEqual(["SLAM", "GoTo"]);
  expect(names(true)).toEqual(["SLAM", "Record", "GoTo"]);
  expect(parted(rows, () => false, false).folded).toBe(2);
});

test("rows fill the room, are 32 px high or more where so many fit, and scroll where even low ones do not", () => {
  expect(heightOfRows(8 * 32, 8, false)).toBe(32);
  expect(heightOfRows(8 * 40 + 7, 8, false)).toBe(40);
  for (const count of [1, 3, 10]) expect(heightOfRows(count * 500, count, false)).toBe(96);
  expect(heightOfRows(8 * 32 - 1, 8, false)).toBe(31);
  expect(heightOfRows(50, 8, false)).toBe(24);
  expect(heightOfRows(50, 8, true)).toBe(36);
  expect(heightOfRows(200, 0, false)).toBe(96);
});
