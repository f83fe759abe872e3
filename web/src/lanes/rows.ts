/** Which classes have a lane; pure. */

import type { DesireClass, LaneRow } from "../protocol/types";

/** The classes that a strategy serves, and those that are desired although none does. */
export function laneRows(rows: readonly LaneRow[], classes: readonly DesireClass[]): LaneRow[] {
  const unserved = new Set(classes.filter(({ served }) => !served).map(({ name }) => name));
  return rows.filter((row) => row.state !== "undesired" || !unserved.has(row.class));
}
