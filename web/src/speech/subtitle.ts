/** What the robot says, as a subtitle. Pure. */

import type { Message } from "../state/latest";

/** How long (s) a sentence stays after its last word. */
export const STAYS_S = 1.5;

/** A sentence in three parts: said already, the word that is said now, still to be said. */
export interface Subtitle {
  before: string;
  word: string;
  after: string;
}

/** The subtitle at `now` (robot's clock; null: not known); null: none is shown. */
export function subtitleOf(speech: Message<"speech"> | null, now: number | null): Subtitle | null {
  if (!speech?.text) return null;
  if (speech.state === "silent" && (now === null || now - speech.stamp > STAYS_S)) return null;
  const { text, word_begin, word_end } = speech;
  // The robot counts characters, JavaScript their halves.
  const characters = Array.from(text);
  const part = (begin: number, end?: number) => characters.slice(begin, end).join("");
  if (speech.state === "silent") return { before: text, word: "", after: "" };
  return { before: part(0, word_begin), word: part(word_begin, word_end), after: part(word_end) };
}
