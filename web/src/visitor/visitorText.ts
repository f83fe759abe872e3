/** What a visitor is shown of the tour, in the visitor's language; pure. */

import type { VisitorView } from "../protocol/types";
import type { Words } from "./words";

type Texts = Readonly<Record<string, string>>;
export type VisitorButton = VisitorView["buttons"][number];

/**
 * The language to show: the one that was chosen here, else the first of the browser's that the tour has, else the one that
 * the robot speaks.
 */
export function languageOf(view: VisitorView, chosen: string | null, browser: readonly string[]): string {
  const { languages, language } = view;
  if (chosen !== null && languages.includes(chosen)) return chosen;
  for (const tag of browser.map((each) => each.toLowerCase())) {
    const primary = tag.split("-")[0];
    const found = languages.find((each) => each === tag) ?? languages.find((each) => each.split("-")[0] === primary);
    if (found) return found;
  }
  return language || "en";
}

/** A text in a language, or where it has none, in one that it has; and in which. */
export function inLanguage(texts: Texts, language: string, view: VisitorView): { text: string; language: string } {
  const used = [language, view.languages[0] ?? "", ...Object.keys(texts)].find((tag) => texts[tag]) ?? language;
  return { text: texts[used] ?? "", language: used };
}

export interface Subtitles {
  language: string;
  sentences: readonly string[];
  /** Index of the one that is said now. */
  now: number;
}

/** The text of this step. Another language may have more or fewer sentences: the same share of them is said by then. */
export function subtitles(view: VisitorView, language: string): Subtitles | null {
  const { sentences } = view;
  const used = [language, view.languages[0] ?? "", ...Object.keys(sentences)].find((tag) => sentences[tag]?.length);
  if (used === undefined) return null;
  const shown = sentences[used]!;
  const spoken = sentences[view.language]?.length ?? shown.length;
  const share = shown.length === spoken ? view.sentence : Math.floor((view.sentence * shown.length) / spoken);
  return { language: used, sentences: shown, now: Math.min(share, shown.length - 1) };
}

/** What the robot does, where it shows and says nothing; empty: it needs no words. */
export function doing(view: VisitorView, words: Words): string {
  switch (view.state) {
    case "idle":
      return view.buttons.includes("start") ? words.begin : words.soon;
    case "leading":
      return words.follow;
    case "waiting":
    case "searching":
      return words.waits;
    case "turning":
    case "blocked":
    case "lost":
    case "paused":
      return words.moment;
  }
  return "";
}

export function buttonWords(button: VisitorButton, view: VisitorView, language: string, words: Words): string {
  if (button === "next") return inLanguage(view.press, language, view).text || words.next;
  return words[button];
}
