/** Where the robot goes for a click in the camera's picture. Pure. */

export interface Spot {
  x: number;
  y: number;
}

/** What is higher (m) is no floor: the robot goes before it and looks at it. */
const FLOOR_M = 0.25;
/** Between the robot and what it goes before (m). */
export const BEFORE_M = 0.9;

/** The goal for a click on `point`, with the robot at `robot`, both on the map; null: it is there already. */
export function goalFor(point: Spot & { z: number }, robot: Spot): (Spot & { heading: number | null }) | null {
  if (point.z <= FLOOR_M) return { x: round(point.x), y: round(point.y), heading: null };
  const [dx, dy] = [point.x - robot.x, point.y - robot.y];
  const distance = Math.hypot(dx, dy);
  if (distance <= BEFORE_M) return null;
  const share = (distance - BEFORE_M) / distance;
  return { x: round(robot.x + share * dx), y: round(robot.y + share * dy), heading: round(Math.atan2(dy, dx)) };
}

function round(value: number): number {
  return Math.round(value * 1000) / 1000;
}
