/** The battery in words for people. */

import type { BatteryState } from "../protocol/types";
import { percent, sentence } from "./format";

/** Below these charges people are warned, as on the robot's timeline. */
const LOW = 0.3;
const VERY_LOW = 0.15;

export interface BatteryWords {
  /** 78 % */
  charge: string;
  /** 3 h, 40 min; empty where it is not known. */
  left: string;
  hint: string;
  tone: "" | "fair" | "poor";
}

export function batteryWords(battery: BatteryState): BatteryWords {
  const left = battery.remaining_s === null ? "" : span(battery.remaining_s);
  const full = battery.charging && battery.charge >= 0.99;
  const doing = full ? "full, on the charger" : battery.charging ? "charging" : "discharging";
  const until = left && !full ? `, ${battery.charging ? "full" : "empty"} in about ${left}` : "";
  return {
    charge: percent(battery.charge),
    left: full ? "full" : left,
    hint: sentence(`battery ${doing}${until}: ${battery.voltage_v.toFixed(1)} V, ${amperes(battery.current_a)}`),
    tone: battery.charge < VERY_LOW ? "poor" : battery.charge < LOW ? "fair" : "",
  };
}

function amperes(current: number): string {
  return `${Math.abs(current).toFixed(1)} A ${current < 0 ? "out" : "in"}`;
}

function span(seconds: number): string {
  if (seconds < 90) return `${Math.ceil(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return `${Math.round(seconds / 3600)} h`;
}
