/** Who drives the robot now, in words; pure. */

import { t, within } from "../i18n";
import { moduleTitle } from "./format";

interface Driving {
  driver: { operator: string; mine: boolean; holds: boolean } | null;
  exploited: string | null;
}

/** The behavior that teleoperation drives through: it still brakes for a moment after a release. */
const BY_HAND = "Teleop";

type Modules = readonly { name: string; title: string }[];

/** The operator who holds a drive command; else the behavior that commands the base; else "Nobody". */
export function driverName(status: Driving | null, modules: Modules): string {
  if (!status) return "–";
  const { driver, exploited } = status;
  if (driver?.holds) return driver.mine ? t("You") : driver.operator;
  return exploited === null || (driver && exploited === BY_HAND) ? t("Nobody") : moduleTitle(exploited, modules);
}

/** The same as a sentence, and who has control. */
export function driverWords(status: Driving | null, modules: Modules): string {
  const driver = status?.driver;
  const name = driverName(status, modules);
  const named = driver?.holds && !driver.mine ? name : name === t("You") || name === t("Nobody") ? within(name) : name;
  const drives = t("Who drives the robot: {name}.", { name: named });
  if (!driver) return drives;
  return `${drives} ${driver.mine ? t("You have control.") : t("{operator} has control.", { operator: driver.operator })}`;
}
