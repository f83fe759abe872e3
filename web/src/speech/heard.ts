/** What words the robot listens for, and what it heard last, in words. Pure. */

import { directionWords } from "../around/perceptMarks";
import { t } from "../i18n";
import type { LaneRow } from "../protocol/types";
import type { Message } from "../state/latest";
import { ago, percent, reasonText, sentence } from "../ui/format";

const LISTEN = "ListenForWords";

export interface Listening {
  words: string[];
  language: string;
  /** Attention's own words, while it does not let the robot listen; else "". */
  reason: string;
}

/** What is listened for by the strongest desire; null: nothing is. */
export function listening(
  desires: Message<"desires"> | null,
  intention: Pick<Message<"intention">, "desires"> | null,
  rows: readonly LaneRow[],
): Listening | null {
  const id = intention?.desires[LISTEN];
  const desire = desires?.desires.find((one) => one.id === id);
  if (!desire || desire.utility === 0) return null;
  const { words, language } = desire.params;
  const row = rows.find((one) => one.class === LISTEN);
  return {
    words: String(words)
      .split(",")
      .map((word) => word.trim())
      .filter(Boolean),
    language: String(language),
    reason: row && row.divisor === null ? sentence(reasonText(row.state, row.text)) : "",
  };
}

/** "yes"; "not understood, perhaps yes". */
export function heardText({ text, unsure, likeliest }: Message<"heard_words">): string {
  if (!unsure) return text;
  return likeliest ? t("not understood, perhaps {likeliest}", { likeliest }) : t("not understood");
}

/** "30° left, 95 % sure, 4 s ago"; `now`: the robot's clock (null: not known). */
export function heardDetails({ direction, confidence, stamp }: Message<"heard_words">, now: number | null): string {
  const parts = [
    directionWords(Math.atan2(direction[1], direction[0])),
    t("{share} sure", { share: percent(confidence) }),
  ];
  if (now !== null) parts.push(ago(now - stamp));
  return parts.join(", ");
}
