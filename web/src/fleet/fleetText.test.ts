import { expect, test } from "vitest";
import type { FleetRobot } from "../protocol/types";
import { nameOf, robotWords } from "./fleetText";

const robot = (given: Partial<FleetRobot>): FleetRobot => ({
  name: "Ada",
  body: "IRL-1",
  url: "http://lab:8080",
  state: "well",
  detail: "",
  driver: null,
  exploited: null,
  charge: null,
  simulated: false,
  ...given,
});

test("a person at the wheel is named before a behavior, and the battery comes last", () => {
  expect(robotWords(robot({ driver: "Bob", exploited: "Teleop", charge: 0.784 }))).toBe(
    "Ready · driven by Bob · battery 78 %",
  );
  expect(robotWords(robot({ exploited: "PlanAndFollowPath" }))).toBe("Ready · drives itself (Plan and follow path)");
  expect(robotWords(robot({ state: "stopped" }))).toBe("Emergency stop");
});

test("a robot that has not answered is called by its address", () => {
  expect(nameOf(robot({ name: "" }))).toBe("lab:8080");
  expect(nameOf(robot({}))).toBe("Ada");
});
