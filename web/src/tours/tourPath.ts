/** A point of a step, found by the step's place in the tour; pure. */

import type { Step, Tour } from "../protocol/types";

export interface PointTarget {
  /** Of the step, as `stops.2.do.0`. */
  path: string;
  part: "point" | "look";
}

type Point = [number, number, number];

/** About as high as eyes. */
const EYES_M = 1.2;

/** `tour` with the point of a step at `x`, `y`; without `z`, as high as it was. */
export function withPoint(
  tour: Tour,
  { path, part }: PointTarget,
  [x, y, z]: readonly [x: number, y: number, z?: number],
): Tour {
  const keys = path.split(".");
  const set = (value: unknown, at: number): unknown => {
    if (at === keys.length) {
      const step = value as Step;
      const before = step[part];
      return { ...step, [part]: [x, y, z ?? (Array.isArray(before) ? before[2] : EYES_M)] satisfies Point };
    }
    const key = keys[at]!;
    if (Array.isArray(value)) return value.map((one, index) => (String(index) === key ? set(one, at + 1) : one));
    const members = value as Record<string, unknown>;
    return { ...members, [key]: set(members[key], at + 1) };
  };
  return set(tour, 0) as Tour;
}
