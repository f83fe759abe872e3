/** What the robot does now, in a word: by the guard's state and by the speed that was measured. Pure. */

import { type Text, t } from "../i18n";
import type { Guard, OdometryReport } from "../protocol/generated";

/** Slower counts as standing: what odometry of a robot at rest may show (m/s, rad/s). */
export const STILL_MPS = 0.02;
export const STILL_RADPS = 0.03;
/** So much faster than it is commanded, the robot brakes (m/s, rad/s). */
const FASTER_MPS = 0.03;
const FASTER_RADPS = 0.1;

const STATES: Record<string, Text> = {
  waiting: "Waiting",
  stale_command: "No fresh command",
  e_stopped: "E-stopped",
  sensor_failure: "Sensor failure",
  silent: "No report",
};

/** `odometry` null: the speed is not known; then a robot that is given none is not said to stand. */
export function motionWords(guard: Guard, odometry: OdometryReport | null): string {
  return t(motionText(guard, odometry));
}

function motionText(guard: Guard, odometry: OdometryReport | null): Text {
  const { state, applied } = guard;
  if (state === "waiting" || state === "silent") return STATES[state]!;
  if (!odometry) return STATES[state] ?? (state === "driving" ? "Driving" : "Speed unknown");
  const speed = Math.hypot(odometry.linear_mps, odometry.lateral_mps);
  const turn = Math.abs(odometry.angular_radps);
  const moves = speed > STILL_MPS || turn > STILL_RADPS;
  if (state === "e_stopped" || state === "sensor_failure") return moves ? "Stopping" : STATES[state]!;
  if (state === "stale_command") return moves ? "Braking" : STATES[state]!;
  const given = Math.hypot(applied.linear_mps, applied.lateral_mps);
  const turned = Math.abs(applied.angular_radps);
  const nothing = given === 0 && turned === 0;
  if (!moves) return state === "driving" && !nothing ? "Starting" : "Standing";
  if (nothing) return "Rolling";
  const brakes = speed > given + FASTER_MPS || turn > turned + FASTER_RADPS;
  return state === "idle" || brakes ? "Braking" : "Driving";
}
