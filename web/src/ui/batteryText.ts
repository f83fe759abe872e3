/** The battery in words for people. */

import { decimals, t } from "../i18n";
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
  const doing = full ? t("full, on the charger") : battery.charging ? t("charging") : t("discharging");
  const until =
    left && !full ? t(battery.charging ? ", full in about {left}" : ", empty in about {left}", { left }) : "";
  return {
    charge: percent(battery.charge),
    left: full ? t("full") : left,
    hint: sentence(
      t("battery {doing}{until}: {volts} V, {current}", {
        doing,
        until,
        volts: decimals(battery.voltage_v.toFixed(1)),
        current: amperes(battery.current_a),
      }),
    ),
    tone: battery.charge < VERY_LOW ? "poor" : battery.charge < LOW ? "fair" : "",
  };
}

function amperes(current: number): string {
  const amperes = decimals(Math.abs(current).toFixed(1));
  return current < 0 ? t("{amperes} A out", { amperes }) : t("{amperes} A in", { amperes });
}

function span(seconds: number): string {
  if (seconds < 90) return `${Math.ceil(seconds)} s`;
  if (seconds < 5400) return t("{minutes} min", { minutes: Math.round(seconds / 60) });
  return `${Math.round(seconds / 3600)} h`;
}
