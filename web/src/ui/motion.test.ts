import { expect, test } from "vitest";
import type { Guard, OdometryReport } from "../protocol/generated";
import { motionWords } from "./motion";

const guard = (state: Guard["state"], linear = 0, angular = 0): Guard => ({
  state,
  reason: "",
  e_stopped: state === "e_stopped",
  command_age_ms: null,
  applied: { linear_mps: linear, angular_radps: angular, lateral_mps: 0 },
});
const moving = (linear: number, angular = 0, lateral = 0): OdometryReport => ({
  x: 0,
  y: 0,
  theta: 0,
  linear_mps: linear,
  angular_radps: angular,
  lateral_mps: lateral,
});

test("it stands only where nothing turns a wheel", () => {
  expect(motionWords(guard("idle"), moving(0))).toBe("Standing");
  expect(motionWords(guard("idle"), moving(-0.015, 0.02))).toBe("Standing");
  for (const rolling of [moving(0.1), moving(0, -0.2), moving(0, 0, 0.1)])
    expect(motionWords(guard("idle"), rolling)).toBe("Rolling");
  expect(motionWords(guard("idle"), null)).toBe("Speed unknown");
});

test("a command that brakes is not taken for one that drives", () => {
  expect(motionWords(guard("driving", 0.4), moving(0))).toBe("Starting");
  expect(motionWords(guard("driving", 0.4), moving(0.3))).toBe("Driving");
  expect(motionWords(guard("driving", 0.1), moving(0.3))).toBe("Braking");
  expect(motionWords(guard("driving", 0, 0.1), moving(0, -0.5))).toBe("Braking");
  expect(motionWords(guard("idle", 0.2), moving(0.2))).toBe("Braking");
  expect(motionWords(guard("driving"), moving(0))).toBe("Standing");
});

test("a stop is said, and whether the robot has come to rest by it", () => {
  expect(motionWords(guard("e_stopped"), moving(0.2))).toBe("Stopping");
  expect(motionWords(guard("e_stopped"), moving(0))).toBe("E-stopped");
  expect(motionWords(guard("stale_command"), moving(0.2))).toBe("Braking");
  expect(motionWords(guard("stale_command"), moving(0))).toBe("No fresh command");
  expect(motionWords(guard("sensor_failure"), moving(0))).toBe("Sensor failure");
  expect(motionWords(guard("silent"), moving(0.2))).toBe("No report");
});
