/**
 * What the program says, in the reader's language as far as that is known: its names of things, and its sentences by
 * their pattern (`{name} keeps the wheel.`). It speaks English; what no pattern knows stays so, and is marked for
 * screen readers by `lang`.
 */

import { decimals, type RobotWords, shown } from "./text";

interface Pattern {
  regex: RegExp;
  names: string[];
  text: string;
}

/** Sentences in sentences are no deeper. */
const DEEPEST = 6;
const made = new WeakMap<RobotWords, Pattern[]>();

/** A name that the program has for something; as it is where the reader's language has none. */
export function named(name: string): string {
  return shown.value.robot?.names[name] ?? name;
}

/** A sentence of the program; as it is where the reader's language has none. */
export function fromRobot(text: string): string {
  const { robot } = shown.value;
  return robot ? (spoken(text, robot) ?? text) : text;
}

/** "en" where the program's `text` stays English on a page of another language. */
export function langOf(text: string): "en" | undefined {
  const { robot } = shown.value;
  return robot && text !== "" && spoken(text, robot) === null ? "en" : undefined;
}

/** What is wrong with a field: the program's `message`, and the rule of its model that the value breaks. */
export interface FieldFault {
  message: string;
  /** Of the rule, as `greater_than`; none: the message alone says it. */
  kind?: string | undefined;
  /** What the rule names, and the value that was `given`. */
  values?: Readonly<Record<string, string | number>> | undefined;
}

/** Whether the reader's language says such a rule by itself, in other words than the program's. */
export function saysRule({ kind }: FieldFault): boolean {
  return shown.value.robot?.rules[kind ?? ""] !== undefined;
}

/** A fault in the reader's language: by its rule, else by the program's sentence. */
export function faultWords({ message, kind, values }: FieldFault): string {
  const { robot } = shown.value;
  const rule = robot?.rules[kind ?? ""];
  if (!robot || rule === undefined) return fromRobot(message);
  return rule.replace(/\{(\w+)\}/g, (whole, name: string) => {
    const said = values?.[name];
    return said === undefined ? whole : value(typeof said === "number" ? String(said) : said, robot, 0);
  });
}

/** A sentence by itself may be one that the program says within others, too: with a capital and a full stop. */
function spoken(text: string, robot: RobotWords): string | null {
  const whole = translated(text, robot);
  if (whole !== null) return whole;
  const bare = text.replace(/\.$/, "");
  const stop = text.slice(bare.length);
  const plain = stop ? translated(bare, robot) : null;
  if (plain !== null) return plain + stop;
  const inner = translated(bare.charAt(0).toLowerCase() + bare.slice(1), robot);
  return inner === null ? null : inner.charAt(0).toUpperCase() + inner.slice(1) + stop;
}

function translated(text: string, robot: RobotWords, depth = 0): string | null {
  const whole = robot.sentences[text] ?? robot.names[text];
  if (whole !== undefined) return whole;
  if (depth > DEEPEST) return null;
  for (const { regex, names, text: into } of patternsOf(robot)) {
    const found = regex.exec(text);
    if (!found) continue;
    return into.replace(/\{(\w+)\}/g, (_, name: string) => value(found[1 + names.indexOf(name)]!, robot, depth + 1));
  }
  return null;
}

/** What stands in a sentence: a sentence, a name, a figure, or what people or the program call something. */
function value(text: string, robot: RobotWords, depth: number): string {
  const whole = translated(text, robot, depth) ?? robot.names[spaceBetween(text)];
  if (whole !== undefined) return whole;
  const last = text.endsWith(".") ? translated(text.slice(0, -1), robot, depth) : null;
  return last === null ? figures(text) : `${last}.`;
}

function figures(text: string): string {
  return /^[−-]?\d+\.\d+(?: (?:s|m|ms|%))?$/.test(text) ? decimals(text) : text;
}

/** `FindQRCodes` as `Find QR codes`. */
export function spaceBetween(name: string): string {
  const words = name
    .replace(/([a-z0-9])([A-Z])/g, "$1 $2")
    .replace(/([A-Z]+)([A-Z][a-z])/g, "$1 $2")
    .split(/[\s_]+/);
  return words.map((word, i) => (i === 0 || /^[A-Z0-9]{2,}/.test(word) ? word : word.toLowerCase())).join(" ");
}

/** The most words first: they say the most of what a sentence is. */
function patternsOf(robot: RobotWords): Pattern[] {
  const known = made.get(robot);
  if (known) return known;
  const said = (text: string) => text.replace(/\{\w+\}/g, "").length;
  const patterns = Object.entries(robot.sentences)
    .filter(([text]) => text.includes("{"))
    .sort(([a], [b]) => said(b) - said(a))
    .map(([text, into]) => {
      const parts = text.split(/\{\w+\}/).map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
      return {
        regex: new RegExp(`^${parts.join("(.+?)")}$`, "s"),
        names: [...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name!),
        text: into,
      };
    });
  made.set(robot, patterns);
  return patterns;
}
