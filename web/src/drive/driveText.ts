/** What the driving controls do, in words; pure. */

import type { GroupReport } from "../protocol/types";
import type { Source } from "./machine";

/** While `source` drives; `goes`: the robot has a goal, to which it continues by itself when the controls are released. */
export function heldWords(source: Source, slow: boolean, goes: boolean): string {
  const then = goes ? "Let go to continue to the goal." : "Let go to stop.";
  return `Driving by ${source}${slow ? ", slowly" : ""}. ${then}`;
}

export interface HeadWords {
  text: string;
  /** The head does not do what it was commanded. */
  warns: boolean;
}

/** What the head does, where that matters to the hand; `held`: this page holds it. */
export function headWords(head: GroupReport | null, held: boolean): HeadWords {
  const because = head?.reason ? `: ${head.reason}` : "";
  switch (head?.state) {
    case "refused":
      return { text: `The head refused the command${because}.`, warns: true };
    case "yielding":
      return { text: `The head yields${because}.`, warns: held };
    case "holding":
      return held ? { text: `The head is held still${because}.`, warns: true } : NOTHING;
    case "moving":
      if (held) return { text: "Turning the head. Let go to hold it.", warns: false };
      return head.exploited ? { text: `${head.exploited} turns the head.`, warns: false } : NOTHING;
    default:
      return NOTHING;
  }
}

const NOTHING: HeadWords = { text: "", warns: false };
