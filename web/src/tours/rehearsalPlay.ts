/** A rehearsal played back: where the robot is, what it says and does at a moment of it; pure. */

import { plural, t } from "../i18n";
import type { Rehearsal, RehearsalProblem, RehearsalReport } from "../protocol/types";
import { clockSpan } from "../ui/format";

/** As fast as it is played at least (times life). */
export const SPEED = 12;
/** A long tour is played faster, so that it is over after this (s). */
const LONGEST_S = 60;

export interface RehearsedMark {
  x: number;
  y: number;
  theta: number;
  /** The way up to there. */
  trail: { x: number; y: number }[];
}

export function speedOf({ duration_s }: Rehearsal): number {
  return Math.max(SPEED, duration_s / LONGEST_S);
}

/** Where the robot is at `at` (s since the begin), between two noted poses; null without any. */
export function markAt({ path }: Rehearsal, at: number): RehearsedMark | null {
  const next = path.findIndex(({ at_s }) => at_s > at);
  const index = next < 0 ? path.length - 1 : Math.max(0, next - 1);
  const from = path[index];
  if (!from) return null;
  const to = path[index + 1] ?? from;
  const span = to.at_s - from.at_s;
  const share = span > 0 ? Math.min(1, Math.max(0, (at - from.at_s) / span)) : 0;
  const turn = Math.atan2(Math.sin(to.heading - from.heading), Math.cos(to.heading - from.heading));
  const here = { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) };
  const trail = [...path.slice(0, index + 1).map(({ x, y }) => ({ x, y })), here];
  return { ...here, theta: from.heading + share * turn, trail };
}

/** What is said at `at`; empty: nothing. */
export function saidAt({ subtitles }: Rehearsal, at: number): string {
  return subtitles.findLast(({ at_s, until_s }) => at_s <= at && at < until_s)?.text ?? "";
}

/** The state at `at`, with its stop and why; null: before it starts. */
export function stateAt({ states }: Rehearsal, at: number): Rehearsal["states"][number] | null {
  return states.findLast(({ at_s }) => at_s <= at) ?? null;
}

/** Problems by stop, in the order in which they come; "" for those of the whole tour. */
export function problemsByStop({ problems }: Rehearsal): Map<string, RehearsalProblem[]> {
  const found = new Map<string, RehearsalProblem[]>();
  for (const problem of problems) found.set(problem.stop, [...(found.get(problem.stop) ?? []), problem]);
  return found;
}

/** "5:20 min, 34 m, 3 stops. The tour is over." in a line. */
export function resultWords({ duration_s, driven_m, stops, outcome }: Rehearsal): string {
  const count = plural(stops.length, "{count} stop", "{count} stops");
  return t("{time} min, {metres} m, {stops} presented: {outcome}.", {
    time: clockSpan(duration_s),
    metres: Math.round(driven_m),
    stops: count,
    outcome,
  });
}

/** What is known of one that runs. */
export function progressWords({ seconds, stop }: RehearsalReport): string {
  if (seconds <= 0) return t("Getting ready…");
  const time = clockSpan(seconds);
  return stop ? t("{time} min played, on the way to or at {stop}", { time, stop }) : t("{time} min played", { time });
}
