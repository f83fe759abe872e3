/** The tour under way in words, and what can be pressed; pure. */

import { fromRobot, plural, type Text, t } from "../i18n";
import type { NavigationModel, RunReport, TourProgress } from "../protocol/types";
import { clockSpan, number, sentence } from "../ui/format";
import { textOf } from "./tourEdits";

export type TourState = TourProgress["state"];
export type Button = TourProgress["buttons"][number];

const STATES: Record<TourState, Text> = {
  idle: "Nobody is led",
  inviting: "Invites visitors",
  confirming: "Asks whether to begin",
  leading: "On its way",
  waiting: "Waits for visitors to catch up",
  searching: "Drives back for visitors",
  turning: "Turns to the visitors",
  presenting: "Presents",
  listening: "Waits for visitors to go on",
  answering: "Answers a question",
  blocked: "Cannot get through",
  lost: "Does not know where it is",
  paused: "Paused",
  parting: "Says goodbye",
  going_home: "On its way home",
};

const WORDS: Record<Button, Text> = {
  start: "Begin now",
  agree: "Visitors say yes",
  decline: "Visitors say no",
  next: "Go on",
  pause: "Pause",
  resume: "Resume",
  retry: "Try again",
  skip: "Skip this stop",
  undo_skip: "Undo skip",
  repeat: "Repeat this stop",
  end: "End the tour",
};

/** Whether a tour is led, or waits for visitors. */
export function isThere(progress: TourProgress | null): progress is TourProgress {
  return progress !== null && progress.tour !== "" && (progress.waits || progress.state !== "idle");
}

/** Of a rehearsal, which has states as text. */
export function stateWord(state: string): string {
  const words: Text | undefined = STATES[state as TourState];
  return words ? t(words) : state;
}

export function stateWords({ state, waits }: TourProgress): string {
  return state === "idle" && waits ? t("Waits for visitors to begin") : t(STATES[state]);
}

/** How the tab says that a tour is under way; empty: none is. */
export function badgeOf(progress: TourProgress | null): string {
  if (!isThere(progress) || progress.state === "idle") return "";
  return progress.number > 0 ? `${progress.number}/${progress.stops}` : t("on|a tour");
}

/** Whether somebody has to look: a question waits, or the robot stands for want of a press. */
export function isUrgent(progress: TourProgress | null): boolean {
  return isThere(progress) && (progress.question !== null || progress.state === "lost" || isHeld(progress));
}

/** Whether no tour begins before a press: the emergency stop was pressed, and is released. */
function isHeld({ state, buttons }: TourProgress): boolean {
  return state === "idle" && buttons.includes("resume");
}

/** "Stop 2 of 3: The arm"; empty where it is at none. */
export function stopWords({ number: at, stops, stop, stop_title, languages }: TourProgress): string {
  if (stop === "") return "";
  const title = textOf(stop_title, languages) || stop;
  return at > 0 ? t("Stop {at} of {stops}: {title}", { at, stops, title }) : title;
}

export function peopleWords({ people, farthest_m }: TourProgress): string {
  if (people === 0) return t("No visitors are seen");
  const count = plural(people, "{count} visitor is seen", "{count} visitors are seen");
  if (farthest_m === null) return count;
  const metres = number(farthest_m);
  return people === 1
    ? t("{count}, {metres} m away", { count, metres })
    : t("{count}, the farthest {metres} m away", { count, metres });
}

/**
 * What keeps a paused tour from going on, and one that waits from beginning; empty: nothing does. `stopped`: the
 * emergency stop is latched now.
 */
export function pauseWords(progress: TourProgress, stopped: boolean): string {
  const { state, question } = progress;
  if (isHeld(progress) && !stopped) return t("Nothing moves until you press Resume.");
  if (state !== "paused" && !(state === "idle" && stopped)) return "";
  if (stopped) return t("Release the emergency stop first. Even then nothing moves until you press Resume.");
  // Who waits for a press asks for it; a pause by hands ends with them.
  return question === null
    ? t("It goes on by itself once nobody drives the robot by hand.")
    : t("Nothing moves until you press Resume.");
}

/** What the robot does without an answer, and when. */
export function defaultWords(question: NonNullable<TourProgress["question"]>, now: number | null): string {
  if (now === null) return t("Without an answer {default}.", { default: fromRobot(question.default) });
  return t("Without an answer {default} in {time} min.", {
    default: fromRobot(question.default),
    time: clockSpan(Math.max(0, Math.ceil(question.until - now))),
  });
}

export function buttonWords(button: Button, { press, languages, state, stop }: TourProgress): string {
  if (button === "next") return textOf(press, languages) || t(WORDS.next);
  if (button === "skip" && stop !== "" && state === "blocked") return t("Skip it");
  return t(WORDS[button]);
}

/** What people press to steer, in an order that stays: what goes on or holds, the way, the end. */
const STEERING: readonly Button[] = ["start", "resume", "pause", "skip", "undo_skip", "repeat", "end"];
/** What people press for visitors who say it aloud. */
const FOR_VISITORS: readonly Button[] = ["agree", "decline", "next"];

export interface Control {
  button: Button;
  words: string;
  /** It stays in its place while it does nothing, so that no thumb meets another. */
  works: boolean;
}

/** Pause and Resume share a place; others keep theirs while a tour is under way. `stopped`: the emergency stop is latched. */
export function controlsOf(progress: TourProgress, stopped: boolean): Control[] {
  const can = (button: Button) => progress.buttons.includes(button) && !(stopped && button === "resume");
  const shown = STEERING.filter((button) => {
    if (button === "start" || button === "pause") return can(button);
    // A paused tour has Resume in any case, if only to see that the emergency stop keeps it from going on.
    if (button === "resume") return progress.state === "paused" || isHeld(progress);
    return progress.state !== "idle";
  });
  return shown.map((button) => ({ button, words: buttonWords(button, progress), works: can(button) }));
}

/** Only what does something now. */
export function visitorControls(progress: TourProgress): Control[] {
  return FOR_VISITORS.filter((button) => progress.buttons.includes(button)).map((button) => ({
    button,
    words: buttonWords(button, progress),
    works: true,
  }));
}

/** A run that is over, in a line: how it ended, and for how long and how many it was. */
export function reportWords(report: RunReport): string {
  const presented = report.stops.filter((stop) => stop.presented).length;
  const people = plural(report.people_most, "{count} visitor", "{count} visitors");
  const stops = plural(presented, "{count} stop presented", "{count} stops presented");
  const time = report.ended === null ? "" : t("{time} min", { time: clockSpan(report.ended - report.began) });
  return `${time && `${time}, `}${people}, ${stops}. ${sentence(report.outcome)}`.trim();
}

/** "never", "once, 0:06 min", "3 times, 1:20 min". */
export function timesWords(times: number, seconds: number): string {
  if (times === 0) return t("never");
  return t("{times}, {time} min", { times: plural(times, "once", "{count} times"), time: clockSpan(seconds) });
}

/** A report names stops by their ids alone, for tours change: `robotics-lab` is "Robotics lab". */
export function idWords(id: string): string {
  const words = id.replace(/-+/g, " ").trim();
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** Why the robot stands on its way, as navigation says; empty: it does not. */
export function standsWords(
  { state, reason }: TourProgress,
  navigation: Pick<NavigationModel, "state" | "reason"> | null,
): string {
  const goes = state === "leading" || state === "going_home";
  const stands = navigation?.state === "waiting" || navigation?.state === "recovering";
  return goes && stands && !reason ? sentence(navigation.reason) : "";
}
