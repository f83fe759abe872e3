import { expect, test } from "vitest";
import type { Recorder, Recording } from "../protocol/types";
import { nameProblem, newestFirst, recordedFor, replayAddress, ringMinutes } from "./recordingText";

const recorder = (change: Partial<Recorder>): Recorder => ({
  stamp: 0,
  state: "recording",
  name: "a",
  began: 1000,
  duration_s: 12,
  bytes: 0,
  messages: 0,
  dropped: 0,
  queued_bytes: 0,
  keep_minutes: 0,
  desired: true,
  reason: "",
  available: true,
  ...change,
});

test("the length counts on between reports, and only then", () => {
  expect(recordedFor(recorder({}), 1012.7)).toBeCloseTo(12.7);
  expect(recordedFor(recorder({}), null)).toBe(12);
  expect(recordedFor(recorder({}), 1500)).toBe(12); // nothing was heard of it for long
  expect(recordedFor(recorder({ state: "stopped" }), 1013)).toBe(12);
  expect(recordedFor(recorder({ state: "ring", duration_s: 300 }), 1900)).toBe(300);
});

test("the newest recording comes first", () => {
  const recording = (name: string, began: number | null): Recording => ({
    name,
    began,
    bytes: 1,
    duration_s: 1,
    state: "complete",
    robot: "",
  });
  const list = [recording("old", 1), recording("z", null), recording("new", 9), recording("y", null)];
  expect(newestFirst(list).map((each) => each.name)).toEqual(["new", "old", "y", "z"]);
});

test("names and minutes are checked as they are typed", () => {
  expect(["", "run-1", "2026.lab_a"].map(nameProblem)).toEqual(["", "", ""]);
  expect(["-a", "../x", "a b", "a".repeat(101)].every((name) => nameProblem(name) !== "")).toBe(true);
  expect(["", " 5 ", "0,5"].map(ringMinutes)).toEqual([null, 5, 0.5]);
  expect(["0", "-1", "x", "121"].every((text) => typeof ringMinutes(text) === "string")).toBe(true);
});

test("a replay opens as its page is: with the 3D view or without, and with its token", () => {
  const from = "http://robot:8080/?scene=off";
  expect(replayAddress("http://robot:9/#token=x", from, true)).toBe("http://robot:9/#token=x");
  expect(replayAddress("http://robot:9/#token=x", from, false)).toBe("http://robot:9/?scene=off#token=x");
});
