/** When a tour begins by itself, and figures of its rules, between its file and what people type; pure. */

import { type Text, t } from "../i18n";
import type { Slot } from "../protocol/types";

export type Day = Slot["days"][number];

export const DAYS: readonly (readonly [day: Day, name: Text])[] = [
  ["mon", "Monday"],
  ["tue", "Tuesday"],
  ["wed", "Wednesday"],
  ["thu", "Thursday"],
  ["fri", "Friday"],
  ["sat", "Saturday"],
  ["sun", "Sunday"],
];

/** On working days, once: to be changed, and allowed as it is. */
export const NEW_SLOT: Slot = { days: ["mon", "tue", "wed", "thu", "fri"], times: ["10:00"] };

/** `values` with or without one of them, in the order of `all`. */
export function chosen<T>(all: readonly T[], values: readonly T[], one: T, on: boolean): T[] {
  return all.filter((each) => (each === one ? on : values.includes(each)));
}

/**
 * "9:30, 14h" as 09:30 and 14:00, in order, each once. What is no time stays as it was typed: the robot says what is
 * wrong with it.
 */
export function timesOf(typed: string): string[] {
  const times = typed
    .split(/[\s,;]+/)
    .filter((part) => part !== "")
    .map((part) => {
      const [, hours, minutes] = /^(\d{1,2})(?:[:.h](\d{2})?)?$/.exec(part) ?? [];
      return hours === undefined ? part : `${hours.padStart(2, "0")}:${minutes ?? "00"}`;
    });
  return [...new Set(times)].sort();
}

/** "Tue, Thu at 14:00, 15:30". */
export function slotWords({ days, times }: Slot): string {
  const names = DAYS.filter(([day]) => days.includes(day)).map(([, name]) => t(name).slice(0, 3));
  return t("{days} at {times}", { days: names.join(", ") || t("no day"), times: times.join(", ") || t("no time") });
}

/** The number that was typed, divided by `scale`: 40 % is 0.4. Null: nothing was typed; NaN: it is no number. */
export function numberOf(typed: string, scale = 1): number | null {
  const plain = typed.replace(",", ".").replace("−", "-").trim();
  if (plain === "") return null;
  return Number.isFinite(Number(plain)) ? rounded(Number(plain), 1 / scale, 6) : Number.NaN;
}

/** Why `typed` cannot be a value; empty: it may be one. */
export function wrongOf(typed: string, range?: readonly [least: number, most: number]): string {
  const number = numberOf(typed);
  const fits = number === null || (range ? range[0] <= number && number <= range[1] : !Number.isNaN(number));
  if (fits) return "";
  const allowed = range ? t("{least} to {most}", { least: range[0], most: range[1] }) : t("a number");
  return t("Not kept: should be {allowed}, not “{typed}”.", { allowed, typed: typed.trim() });
}

export function numberShown(value: number | null, scale = 1): string {
  return value === null ? "" : String(rounded(value, scale, 4));
}

/** In another unit, to so many digits: 0.29 is 29 %, 0.2 rad are 11.46°. */
function rounded(value: number, scale: number, digits: number): number {
  return scale === 1 ? value : Number((value * scale).toPrecision(digits));
}

/** One text a line. */
export function linesOf(typed: string): string[] {
  return typed
    .split("\n")
    .map((line) => line.trim())
    .filter((line) => line !== "");
}
