/** Robots of a fleet in words. Pure. */

import { fromRobot, type Text, t } from "../i18n";
import type { FleetRobot } from "../protocol/types";
import { percent, spaced } from "../ui/format";

export const STATES: Record<FleetRobot["state"], Text> = {
  well: "Ready",
  stopped: "Emergency stop",
  problem: "Problem",
  refused: "Asks for a login",
  unreachable: "Not reached",
};

/** "Ready · driven by Bob · 78 %". */
export function robotWords(robot: FleetRobot): string {
  const words: string[] = [t(STATES[robot.state])];
  if (robot.driver) words.push(t("driven by {name}", { name: robot.driver }));
  else if (robot.exploited) words.push(t("drives itself ({behavior})", { behavior: spaced(robot.exploited) }));
  if (robot.charge !== null) words.push(t("battery {charge}", { charge: percent(robot.charge) }));
  return words.join(" · ");
}

/** What is wrong, where there is more to say than its state; "" where there is not. */
export function detailWords(robot: FleetRobot): string {
  return robot.detail ? fromRobot(robot.detail) : "";
}

/** What a robot is called that has not said its name: its address. */
export function nameOf(robot: FleetRobot): string {
  return robot.name || robot.url.replace(/^https?:\/\//, "");
}
