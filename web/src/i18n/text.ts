/**
 * The page's texts in the reader's language. The English text is its own key: `t("Take over")`,
 * `t("Recording of {robot}", { robot })`, `plural(stops, "1 stop", "{count} stops")`.
 *
 * What is spelled alike in English and not elsewhere says what it is after a bar, which is not shown: `t("Drive|preset")`.
 * A text must be in `fr/`: the compiler refuses others, and `texts.test.ts` refuses what is left over there.
 */

import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { fr } from "./fr";

export const LANGUAGES = { en: "English", fr: "Français" } as const;
export type Language = keyof typeof LANGUAGES;

/** A plural's forms in another language; `other` is there always. */
export type Forms = Partial<Record<Intl.LDMLPluralRule, string>> & { other: string };
export type Catalogue = Readonly<Record<string, string | Forms>>;

type Key = keyof typeof fr;
type Names<S extends string> = S extends `${string}{${infer Name}}${infer Rest}` ? Name | Names<Rest> : never;

/** An English text of the page, as a whole or with places for values: `{name}`. */
type Template = { [Each in Key]: (typeof fr)[Each] extends string ? Each : never }[Key];
/** An English text as a whole, as tables of texts have it. */
export type Text = { [Each in Template]: Names<Each> extends never ? Each : never }[Template];
/** The English text of several; `{count}` in it is how many. */
export type PluralText = Exclude<Key, Template>;
type Values<S extends string, Value, Given extends string = never> = [Exclude<Names<S>, Given>] extends [never]
  ? []
  : [values: Readonly<Record<Exclude<Names<S>, Given>, Value>>];
type Value = string | number;

/**
 * What the program says, by its English: names of things, and sentences with places for what is in them. `rules`, by the
 * type of the error: what a field's value has to be, with places for what the rule names.
 */
export interface RobotWords {
  names: Readonly<Record<string, string>>;
  sentences: Readonly<Record<string, string>>;
  rules: Readonly<Record<string, string>>;
}

/** What the page is shown in; set by `language.ts` alone. */
export interface Shown {
  language: Language;
  /** With the reader's region, for dates: `fr-CA`. */
  tag: string;
  /** Null: English, which needs none. */
  catalogue: Catalogue | null;
  robot: RobotWords | null;
}
export const shown = signal<Shown>({ language: "en", tag: "en", catalogue: null, robot: null });

/** `text` in the reader's language. */
export function t<const S extends Template>(text: S, ...[values]: Values<S, Value>): string {
  return filled(found(text), values);
}

/** The same where elements stand in a sentence: `rich("Hold {keys}", { keys: <kbd>W</kbd> })`. */
export function rich<const S extends Template>(
  text: S,
  ...[values]: Values<S, ComponentChildren>
): ComponentChildren[] {
  const given = (values ?? {}) as Readonly<Record<string, ComponentChildren>>;
  return found(text)
    .split(/\{(\w+)\}/)
    .map((part, at) => (at % 2 === 0 ? part : given[part]));
}

/** `one` or `other`, whichever `count` asks for; `{count}` in either is the number. */
export function plural<const S extends PluralText>(
  count: number,
  one: string,
  other: S,
  ...[values]: Values<S, Value, "count">
): string {
  const { language, catalogue } = shown.value;
  const forms = catalogue?.[other] as Forms | undefined;
  const rule = rules(language).select(count);
  const text = forms ? (forms[rule] ?? forms.other) : rule === "one" ? one : plain(other);
  return filled(text, { count, ...(values as object) });
}

/** A number that is written already, with the language's decimal sign. */
export function decimals(written: string): string {
  return shown.value.language === "en" ? written : written.replace(".", decimalSign(shown.value.language));
}

/** "A, B and C". */
export function listed(words: readonly string[]): string {
  if (words.length < 2) return words[0] ?? "";
  return t("{words} and {last}", { words: words.slice(0, -1).join(", "), last: words.at(-1)! });
}

/** With a lower-case first letter, for a place within a sentence. */
export function within(text: string): string {
  return text.charAt(0).toLowerCase() + text.slice(1);
}

function found(text: string): string {
  const other = shown.value.catalogue?.[text];
  return typeof other === "string" ? other : plain(text);
}

function plain(text: string): string {
  const bar = text.lastIndexOf("|");
  return bar < 0 ? text : text.slice(0, bar);
}

function filled(text: string, values: Readonly<Record<string, Value>> | undefined): string {
  if (!values) return text;
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => {
    const value = values[name];
    return value === undefined ? whole : typeof value === "number" ? decimals(String(value)) : value;
  });
}

const made = new Map<string, { rules: Intl.PluralRules; sign: string }>();

function of(language: Language) {
  const known = made.get(language);
  if (known) return known;
  const parts = new Intl.NumberFormat(language).formatToParts(0.5);
  const sign = parts.find(({ type }) => type === "decimal")!.value;
  const one = { rules: new Intl.PluralRules(language), sign };
  made.set(language, one);
  return one;
}

const rules = (language: Language) => of(language).rules;
const decimalSign = (language: Language) => of(language).sign;
