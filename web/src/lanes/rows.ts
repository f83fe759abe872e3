/** Which classes have a lane; pure. */

import type { DesireClass, Divisors, LaneRow } from "../protocol/types";
import { percent } from "../ui/format";

const ROW_MIN = 24;
/** In a tab the figures stand below the name. */
const ROW_MIN_TAB = 36;
const ROW_MAX = 96;

/** How high (CSS pixels) each of `count` rows is where `room` is left for them; where they do not fit, they scroll. */
export function heightOfRows(room: number, count: number, inTab: boolean): number {
  return Math.max(inTab ? ROW_MIN_TAB : ROW_MIN, Math.min(ROW_MAX, Math.floor(room / Math.max(1, count))));
}

/** The classes that a strategy serves, and those that are desired although none does. */
export function laneRows(rows: readonly LaneRow[], classes: readonly DesireClass[]): LaneRow[] {
  const unserved = new Set(classes.filter(({ served }) => !served).map(({ name }) => name));
  return rows.filter((row) => row.state !== "undesired" || !unserved.has(row.class));
}

/** The rows that are shown, and how many are folded: those that nothing desires, nor desired in what is seen. */
export function parted(
  rows: readonly LaneRow[],
  wasDesired: (name: string) => boolean,
  all: boolean,
): { shown: LaneRow[]; folded: number } {
  const shown = rows.filter((row) => all || row.state !== "undesired" || wasDesired(row.class));
  return { shown, folded: rows.length - shown.length };
}

/** Whether people would read the same: rates are read in whole percent. */
export function sameRows(one: readonly LaneRow[], other: readonly LaneRow[]): boolean {
  return one.length === other.length && one.every((row, index) => sameRow(row, other[index]!));
}

function sameRow(one: LaneRow, other: LaneRow): boolean {
  return (
    one.class === other.class &&
    one.state === other.state &&
    one.text === other.text &&
    one.intensity === other.intensity &&
    one.utility === other.utility &&
    one.divisor === other.divisor &&
    percent(one.rate) === percent(other.rate) &&
    sameDivisors(one.divisors, other.divisors)
  );
}

export function sameDivisors(one: Divisors, other: Divisors): boolean {
  const names = Object.keys(one);
  return names.length === Object.keys(other).length && names.every((name) => one[name] === other[name]);
}
