/** Which language the page speaks: this browser's own choice, else the first of the reader's languages that is known. */

import { LANGUAGES, type Language, type Shown, shown } from "./text";

const KEY = "hbba.language";

/** Each catalogue is a file of its own, fetched when it is first asked for. */
const CATALOGUES: Record<Exclude<Language, "en">, () => Promise<Pick<Shown, "catalogue" | "robot">>> = {
  fr: async () => {
    const { fr, robot } = await import("./fr");
    return { catalogue: fr, robot };
  },
};
const NONE = { catalogue: null, robot: null };

interface Reader {
  /** Carries `lang`, for screen readers, hyphens and quotes. */
  root: HTMLElement;
  storage: Pick<Storage, "getItem" | "setItem">;
  /** As `navigator.languages`: what the reader reads, best first. */
  reads: readonly string[];
}

/** The kept choice, else the first of `reads` that the page speaks, else English. */
export function languageOf(kept: string | null, reads: readonly string[]): Language {
  const tags = [kept ?? "", ...reads].map((tag) => tag.toLowerCase().split("-")[0]);
  return tags.find((tag): tag is Language => tag !== undefined && tag in LANGUAGES) ?? "en";
}

export async function startLanguage(reader: Reader): Promise<void> {
  await show(languageOf(reader.storage.getItem(KEY), reader.reads), reader);
}

/** Shows `language` from now on, here and after a reload; nothing else of the page changes. */
export async function chooseLanguage(language: Language, reader: Reader): Promise<void> {
  await show(language, reader);
  reader.storage.setItem(KEY, language);
}

/** Of this window. */
export function thisReader(): Reader {
  return { root: document.documentElement, storage: localStorage, reads: navigator.languages };
}

async function show(language: Language, { root, reads }: Reader): Promise<void> {
  const texts = language === "en" ? NONE : await CATALOGUES[language]();
  const tag = reads.find((each) => each.toLowerCase().split("-")[0] === language) ?? language;
  shown.value = { language, tag, ...texts };
  root.lang = language;
}
