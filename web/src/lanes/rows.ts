/** Which classes have a lane; pure. */

import type { DesireClass, LaneRow } from "../protocol/types";

/** All that anything here serves, and what somebody desires all the same. */
export function laneRows(rows: readonly LaneRow[], classes: readonly DesireClass[]): LaneRow[] {
  const unserved = new Set(classes.filter(({ served }) => !served).map(({ name }) => name));
  return rows.filter((row) => row.state !== "undesired" || !unserved.has(row.class));
}
