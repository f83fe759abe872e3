import { expect, test } from "vitest";
import type { BatteryState } from "../protocol/types";
import { batteryWords } from "./batteryText";

const battery = (more: Partial<BatteryState>): BatteryState => ({
  stamp: 1,
  charge: 0.784,
  voltage_v: 25.61,
  current_a: -2.04,
  charging: false,
  remaining_s: 3 * 3600,
  ...more,
});

test("charge, and the time until it is empty", () => {
  expect(batteryWords(battery({}))).toEqual({
    charge: "78 %",
    left: "3 h",
    hint: "Battery discharging, empty in about 3 h: 25.6 V, 2.0 A out.",
    tone: "",
  });
});

test("while it charges, the time until it is full; once it is, that", () => {
  const charging = batteryWords(battery({ charging: true, current_a: 4, remaining_s: 2400 }));
  expect([charging.left, charging.hint]).toEqual([
    "40 min",
    "Battery charging, full in about 40 min: 25.6 V, 4.0 A in.",
  ]);
  const full = batteryWords(battery({ charge: 1, charging: true, current_a: 0, remaining_s: null }));
  expect([full.charge, full.left, full.hint]).toEqual([
    "100 %",
    "full",
    "Battery full, on the charger: 25.6 V, 0.0 A in.",
  ]);
});

test("yellow under 30 %, red under 15 %", () => {
  const tones = [0.3, 0.299, 0.15, 0.149].map((charge) => batteryWords(battery({ charge })).tone);
  expect(tones).toEqual(["", "fair", "fair", "poor"]);
});

test("where nothing flows there is no time", () => {
  expect(batteryWords(battery({ remaining_s: null })).left).toBe("");
});
