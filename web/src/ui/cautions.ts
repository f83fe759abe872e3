/** What the bar says of how the program is configured. Pure. */

import { fromRobot, t } from "../i18n";
import type { Caution } from "../protocol/types";
import { sentence } from "./format";

/** A few words for the bar and all there is to know; null where there is nothing to know. */
export function cautionWords(cautions: readonly Caution[]): { title: string; text: string } | null {
  const [first] = cautions;
  if (!first) return null;
  const sentences = cautions.map(
    ({ text, where }) => `${sentence(text).replace(/\.$/, "")}${where ? ` (${where})` : ""}.`,
  );
  const more = cautions.length - 1;
  const title = fromRobot(first.title);
  return {
    title: more ? t("{title}, and {more} more", { title, more }) : title,
    text: sentences.join("\n"),
  };
}
