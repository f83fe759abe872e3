/** What the driving controls do, in words; pure. */

import type { Source } from "./machine";

/** While `source` drives; `goes`: the robot has a goal, to which it continues by itself when the controls are released. */
export function heldWords(source: Source, slow: boolean, goes: boolean): string {
  const then = goes ? "Let go to continue to the goal." : "Let go to stop.";
  return `Driving by ${source}${slow ? ", slowly" : ""}. ${then}`;
}
