/** What the bar says of how the program is configured. Pure. */

import { t } from "../i18n";
import type { Caution } from "../protocol/types";

/** A few words for the bar and all there is to know; null where there is nothing to know. */
export function cautionWords(cautions: readonly Caution[]): { title: string; text: string } | null {
  const [first] = cautions;
  if (!first) return null;
  const sentences = cautions.map(
    ({ text, where }) => `${text[0]!.toUpperCase()}${text.slice(1)}${where ? ` (${where})` : ""}.`,
  );
  const more = cautions.length - 1;
  return {
    title: more ? t("{title}, and {more} more", { title: first.title, more }) : first.title,
    text: sentences.join("\n"),
  };
}
