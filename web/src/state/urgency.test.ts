import { expect, test } from "vitest";
import type { FromRobot } from "../protocol/types";
import type { Message } from "./latest";
import { urgent } from "./urgency";

type Status = Message<"status">;

const idle = {
  type: "status",
  guard: { state: "idle", e_stopped: false, reason: "" },
  driver: null,
  exploited: null,
  limited: "",
  waits: "",
} as unknown as Status;

const other = (change: object): Status => ({ ...idle, ...change });

test("a status that says the same as the one shown can wait", () => {
  expect(urgent(other({ stamp: 3 }), idle, true)).toBe(false);
  expect(urgent(other({ limited: "wall" }), other({ limited: "person" }), true)).toBe(false);
});

test("what a driver's hand answers to is shown at once", () => {
  for (const change of [
    { guard: { ...idle.guard, state: "driving" } },
    { guard: { ...idle.guard, e_stopped: true } },
    { driver: { operator: "Ann", mine: false } },
    { exploited: "Teleoperate" },
    { limited: "wall ahead" },
    { waits: "commands come too late" },
  ])
    expect(urgent(other(change), idle, true)).toBe(true);
});

test("the first signs of life are shown at once", () => {
  expect(urgent(idle, null, true)).toBe(true);
  expect(urgent(idle, idle, false)).toBe(true);
});

test("a recording's transport is shown at once, perception is not", () => {
  expect(urgent({ type: "playback" } as FromRobot, null, true)).toBe(true);
  expect(urgent({ type: "lanes" } as FromRobot, null, true)).toBe(false);
});
