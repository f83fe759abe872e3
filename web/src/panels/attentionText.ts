/** What attention made of the desires, in words for people who do not know its strategies. Pure. */

import { listed, type Text, t } from "../i18n";
import type { Intention, SelectedStrategy } from "../protocol/types";
import { number, spaced } from "../ui/format";

export type Reason = Intention["reasons"][string];

/** What comes over a port, by the port's name: where from, and one piece of it. */
const PIECES: Readonly<Record<string, readonly [from: Text, piece: Piece]>> = {
  images: ["camera", "picture"],
  panorama: ["all-round camera", "picture"],
  kinect: ["camera", "picture"],
  scans: ["laser", "scan"],
  scan: ["laser", "scan"],
  audio: ["sound", "frame"],
  microphones: ["sound", "frame"],
  persons: ["people", "report"],
  words: ["words", "report"],
  regions: ["what moves", "report"],
  saliency: ["what stands out", "report"],
  twist: ["driving", "command"],
  command: ["movement", "command"],
};
const ORDINALS = ["second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth"] as const;

type Piece = keyof typeof SHARES;
/** Of several pieces one comes, by an ordinal or by a number. */
const SHARES = {
  picture: ["every {nth} picture", "one picture in {phi}"],
  scan: ["every {nth} scan", "one scan in {phi}"],
  frame: ["every {nth} frame", "one frame in {phi}"],
  report: ["every {nth} report", "one report in {phi}"],
  command: ["every {nth} command", "one command in {phi}"],
  message: ["every {nth} message", "one message in {phi}"],
} as const;

/** "camera: every second picture", "sound: nothing", "laser: all". */
export function filterWords(port: string, phi: number | null): string {
  const [from, piece] = sourceOf(port);
  if (phi === null) return t("{from}: nothing", { from });
  if (phi === 1) return t("{from}: all", { from });
  const [every, oneIn] = SHARES[piece];
  const ordinal = Number.isInteger(phi) ? ORDINALS[phi - 2] : undefined;
  return t("{from}: {share}", {
    from,
    share: ordinal ? t(every, { nth: t(ordinal) }) : t(oneIn, { phi: number(phi) }),
  });
}

function sourceOf(port: string): readonly [from: string, piece: Piece] {
  const name = port.slice(port.indexOf(".") + 1);
  const known = PIECES[name];
  return known ? [t(known[0]), known[1]] : [spaced(name).toLowerCase(), "message"];
}

/** What a strategy takes in, each source once: that of which least is left out. */
export function intake(strategies: readonly SelectedStrategy[]): string[] {
  const least = new Map<string, { port: string; phi: number | null }>();
  for (const { filters } of strategies)
    for (const [port, phi] of Object.entries(filters)) {
      const [source] = sourceOf(port);
      const known = least.get(source);
      if (!known || (phi ?? Infinity) < (known.phi ?? Infinity)) least.set(source, { port, phi });
    }
  return [...least.values()].map(({ port, phi }) => filterWords(port, phi));
}

/** What was given up comes first, the most missed at the top; then what has all that it could get. */
export function sorted(reasons: Readonly<Record<string, Reason>>): {
  given: [string, Reason][];
  best: [string, Reason][];
} {
  const all = Object.entries(reasons);
  const isGiven = (reason: Reason) => reason.state !== "fulfilled";
  const missed = (reason: Reason) =>
    ({ unfulfilled: 200, inhibited: 0, degraded: 100, fulfilled: 0 })[reason.state] + reason.best - reason.utility;
  return {
    given: all.filter(([, reason]) => isGiven(reason)).sort(([, a], [, b]) => missed(b) - missed(a)),
    best: all.filter(([, reason]) => !isGiven(reason)),
  };
}

/** The answer in one sentence: what the robot gave up. */
export function headline(reasons: Readonly<Record<string, Reason>>): string {
  const { given, best } = sorted(reasons);
  if (given.length + best.length === 0) return t("Nothing is desired: the robot attends to nothing.");
  const of = (state: Reason["state"]) => given.filter(([, reason]) => reason.state === state).map(([name]) => name);
  const parts = [
    said(of("unfulfilled"), "gave up {classes}"),
    said(of("degraded"), "gives less to {classes}"),
    said(of("inhibited"), "holds back {classes}"),
  ].filter(Boolean);
  if (parts.length === 0) return t("Everything that is desired gets all it can use.");
  return t("The robot {deeds}.", { deeds: parts.join(", ") });
}

/** What is left of a need of the strategy, and what would bring the rest, without the state that stands before it. */
export function shortfall({ state, utility, best }: Reason): string {
  if (state !== "degraded" || best <= 0) return "";
  return t("{share} % of its best", { share: Math.round((100 * utility) / best) });
}

/** Why it has no more, without the names of strategies: what would bring the rest, as far as that is known. */
export function plainReason({ state, text }: Reason): string {
  const remedy = /; (would get .*)$/.exec(text)?.[1];
  if (state !== "degraded") return text;
  return remedy?.replace(/^would get [\d.]+ with/, "would be at its best with") ?? "";
}

function said(
  names: readonly string[],
  deed: "gave up {classes}" | "gives less to {classes}" | "holds back {classes}",
): string {
  return names.length === 0 ? "" : t(deed, { classes: listed(names.map(spaced)) });
}
