/** What the driving controls do, in words; pure. */

import { fromRobot, type Text, t } from "../i18n";
import type { GroupReport } from "../protocol/types";
import type { Source } from "./machine";

const DRIVING: Record<Source, Text> = {
  keyboard: "Driving by keyboard.",
  stick: "Driving by stick.",
  gamepad: "Driving by gamepad.",
};
const SLOWLY: Record<Source, Text> = {
  keyboard: "Driving by keyboard, slowly.",
  stick: "Driving by stick, slowly.",
  gamepad: "Driving by gamepad, slowly.",
};

/** While `source` drives; `goes`: the robot has a goal, to which it continues by itself when the controls are released. */
export function heldWords(source: Source, slow: boolean, goes: boolean): string {
  const then = goes ? t("Let go to continue to the goal.") : t("Let go to stop.");
  return `${t((slow ? SLOWLY : DRIVING)[source])} ${then}`;
}

export interface HeadWords {
  text: string;
  /** The head does not do what it was commanded. */
  warns: boolean;
}

/** What the head does, where that matters to the hand; `held`: this page holds it. */
export function headWords(head: GroupReport | null, held: boolean): HeadWords {
  const because = head?.reason ? t(": {reason}", { reason: fromRobot(head.reason) }) : "";
  switch (head?.state) {
    case "refused":
      return { text: t("The head refused the command{because}.", { because }), warns: true };
    case "yielding":
      return { text: t("The head yields{because}.", { because }), warns: held };
    case "holding":
      return held ? { text: t("The head is held still{because}.", { because }), warns: true } : NOTHING;
    case "moving":
      if (held) return { text: t("Turning the head. Let go to hold it."), warns: false };
      return head.exploited
        ? { text: t("{exploited} turns the head.", { exploited: head.exploited }), warns: false }
        : NOTHING;
    default:
      return NOTHING;
  }
}

const NOTHING: HeadWords = { text: "", warns: false };
