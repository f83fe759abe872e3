/** Which messages must not wait for the page's next turn. */

import type { FromRobot } from "../protocol/types";
import type { Message } from "./latest";

type Status = Message<"status">;

/**
 * Whether `message` is shown at once: what a driver's hand answers to (who drives, whether the robot moves, is held up
 * or stopped), the first signs of life, and a recording's transport. `known` is the status shown; `live` whether the page
 * says that it hears the robot.
 */
export function urgent(message: FromRobot, known: Status | null, live: boolean): boolean {
  if (message.type === "playback") return true;
  if (message.type !== "status") return false;
  return !live || known === null || hand(message) !== hand(known);
}

function hand({ guard, driver, exploited, limited, waits }: Status): string {
  return JSON.stringify([guard.state, guard.e_stopped, driver, exploited, limited !== "", waits !== ""]);
}
