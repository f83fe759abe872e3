import { expect, test } from "vitest";
import type { DesireClass, LaneRow } from "../protocol/types";
import { laneRows } from "./rows";

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
