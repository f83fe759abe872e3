/** A tour as REST has it, and edits of it as functions; pure. */

import type { Landmark, Question, Step, Stop, Tour } from "../protocol/types";

/** Texts by language. */
export type Texts = Record<string, string>;

/** What is needed to create a tour; the robot adds the usual values of all else. */
export type NewTour = Pick<Tour, "format" | "id" | "title" | "languages" | "map"> & { stops: Stop[] };

export const LONGEST_ID = 40;
const LONGEST_TITLE = 100;

export const NO_STEP: Step = {
  say: null,
  look: null,
  point: null,
  show: null,
  gesture: null,
  expression: null,
  wait: null,
};

/** What a step may do, in the order of its form. */
export const PARTS = ["say", "look", "point", "show", "gesture", "expression", "wait"] as const;
export type Part = (typeof PARTS)[number];

/** An id that none of `taken` is: "The arm" becomes `the-arm`, or `the-arm-2`. */
export function newId(name: string, taken: readonly string[], nameless = "stop"): string {
  const plain =
    name
      .normalize("NFKD")
      .replace(/[^\x20-\x7e]/g, "")
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, "-")
      .replace(/^-+|-+$/g, "")
      .slice(0, LONGEST_ID)
      .replace(/-+$/, "") || nameless;
  for (let number = 1; ; number++) {
    const end = number === 1 ? "" : `-${number}`;
    const id = `${plain.slice(0, LONGEST_ID - end.length).replace(/-+$/, "")}${end}`;
    if (!taken.includes(id)) return id;
  }
}

export function newTour(title: string, language: string, map: string, taken: readonly string[]): NewTour {
  const id = newId(title, taken, "tour");
  return { format: 1, id, title: { [language]: titleLine(title) }, languages: [language], map, stops: [] };
}

/** A stop at a place: before a poster, if its text is given. */
export function newStop(tour: Pick<Tour, "languages" | "stops">, place: string, title: string, poster = ""): Stop {
  const ids = tour.stops.map(({ id }) => id);
  // A code that names a stop means the stop of this id.
  const named = stopNamed(poster);
  return {
    id: named !== null && !ids.includes(named) ? named : newId(title, ids),
    place,
    title: { [tour.languages[0] ?? "en"]: titleLine(title) },
    poster: poster || null,
    stand: { face: "visitors", tolerance_m: 0.3, tolerance_rad: 0.2 },
    do: [],
    questions: [],
    words: {},
    on_failure: {
      reach: { retry: null, ask_s: null, then: null },
      present: { retry: null, then: null },
    },
    left_out: false,
  };
}

/** "tour:robotics lab" is about "Robotics lab", `HBBA:STOP/ROBOT-LAB` about "Robot lab". */
export function posterTitle(text: string): string {
  const named = stopNamed(text);
  const words = (named === null ? text.replace(/^[a-z]+:\s*/i, "") : named.replace(/-/g, " ")).trim() || text;
  return titleLine(words.charAt(0).toUpperCase() + words.slice(1));
}

function stopNamed(text: string): string | null {
  const id = /^HBBA:STOP\/([A-Z0-9-]{1,40})(?:\/|$)/i.exec(text)?.[1]?.toLowerCase() ?? null;
  return id !== null && /^[a-z0-9]/.test(id) ? id : null;
}

function titleLine(title: string): string {
  return title.replace(/\s+/g, " ").trim().slice(0, LONGEST_TITLE).trim() || "Stop";
}

export function withStop(tour: Tour, stop: Stop, at = tour.stops.length): Tour {
  return { ...tour, stops: tour.stops.toSpliced(at, 0, stop) };
}

export function withoutStop(tour: Tour, id: string): Tour {
  return { ...tour, stops: tour.stops.filter((stop) => stop.id !== id) };
}

/** The stop with this id goes to place `to`, as counted without it; beyond either end is that end. */
export function stopMoved(tour: Tour, id: string, to: number): Tour {
  return { ...tour, stops: moved(tour.stops, (stop) => stop.id === id, to) };
}

export function stopChanged(tour: Tour, id: string, change: Partial<Stop>): Tour {
  return { ...tour, stops: tour.stops.map((stop) => (stop.id === id ? { ...stop, ...change } : stop)) };
}

/** `text` in a language; none, or space alone: it has none in it. */
export function withText(texts: Texts | null, language: string, text: string): Texts {
  const { [language]: _, ...others } = texts ?? {};
  return text.trim() === "" ? others : { ...others, [language]: text };
}

/** The text, in the first of `languages` that has one. */
export function textOf(texts: Texts | null | undefined, languages: readonly string[]): string {
  for (const language of languages) if (texts?.[language]) return texts[language];
  return Object.values(texts ?? {})[0] ?? "";
}

export function stepChanged(steps: readonly Step[], at: number, change: Partial<Step>): Step[] {
  return steps.map((step, number) => (number === at ? { ...step, ...change } : step));
}

/** A step that does nothing is none. */
export function withoutIdle(steps: readonly Step[]): Step[] {
  return steps.filter(does);
}

export function does(step: Step): boolean {
  return PARTS.some((part) => {
    const value = step[part];
    return value !== null && (part !== "say" || Object.keys(value).length > 0);
  });
}

export function stepMoved(steps: readonly Step[], from: number, to: number): Step[] {
  const chosen = steps[from];
  return chosen ? moved(steps, (step) => step === chosen, to) : [...steps];
}

export function newQuestion(stop: Stop, languages: readonly string[]): Question {
  const language = languages[0] ?? "en";
  return {
    id: newId(
      "question",
      stop.questions.map(({ id }) => id),
    ),
    question: { [language]: "What is this?" },
    words: {},
    answer: { ...NO_STEP, say: { [language]: "…" } },
  };
}

/** "next, go on" as words to listen for. */
export function wordsOf(typed: string): string[] {
  return typed
    .split(",")
    .map((word) => word.trim().toLowerCase())
    .filter((word) => word !== "");
}

export function withWords(words: Record<string, string[]>, language: string, typed: string): Record<string, string[]> {
  const { [language]: _, ...others } = words;
  const found = wordsOf(typed);
  return found.length > 0 ? { ...others, [language]: found } : others;
}

/** The stop before this poster, if the tour has one. */
export function stopOf(tour: Pick<Tour, "stops">, { text }: Pick<Landmark, "text">): Stop | null {
  return tour.stops.find(({ poster }) => poster === text) ?? null;
}

function moved<T>(all: readonly T[], chosen: (one: T) => boolean, to: number): T[] {
  const from = all.findIndex(chosen);
  if (from < 0) return [...all];
  const rest = all.toSpliced(from, 1);
  return rest.toSpliced(Math.max(0, Math.min(rest.length, to)), 0, all[from]!);
}
