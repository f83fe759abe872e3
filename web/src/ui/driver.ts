/** Who drives the robot now, in words; pure. */

import { moduleTitle } from "./format";

interface Driving {
  driver: { operator: string; mine: boolean; holds: boolean } | null;
  exploited: string | null;
}

/** The behavior of hands: it brakes for a moment after they have let go, and drives nobody anywhere. */
const BY_HAND = "Teleop";

type Modules = readonly { name: string; title: string }[];

/** Whoever holds a drive command; else the behavior that commands the base; else nobody, whoever has the wheel. */
export function driverName(status: Driving | null, modules: Modules): string {
  if (!status) return "–";
  const { driver, exploited } = status;
  if (driver?.holds) return driver.mine ? "You" : driver.operator;
  return exploited === null || (driver && exploited === BY_HAND) ? "Nobody" : moduleTitle(exploited, modules);
}

/** The same as a sentence, and who has the wheel. */
export function driverWords(status: Driving | null, modules: Modules): string {
  const name = driverName(status, modules);
  const drives = `Who drives the robot: ${name === "You" || name === "Nobody" ? name.toLowerCase() : name}.`;
  const driver = status?.driver;
  if (!driver) return drives;
  return `${drives} ${driver.mine ? "You have" : `${driver.operator} has`} the wheel.`;
}
