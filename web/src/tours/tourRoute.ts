/** The way of a tour: which places are joined, and what their legs are in words; pure. */

import { t } from "../i18n";
import type { Place, RouteLegReport, RoutePoint, RouteReport, Step, Tour } from "../protocol/types";
import { number } from "../ui/format";

/** Words of speech a second: 145 a minute. */
const WORDS_S = 145 / 60;

export interface Leg {
  /** Id of the stop to which it leads; null: home. */
  stop: string | null;
  state: RouteLegReport["state"];
  reason: string;
  length_m: number;
  duration_s: number;
  path: readonly (readonly [number, number])[];
}

/** What to ask the planner, and to which stop each of the legs leads; `lacking`: legs that need no planner. */
export interface Itinerary {
  points: RoutePoint[];
  to: (string | null)[];
  lacking: Leg[];
}

/** From home, where there is one, to every stop that is not left out, and home again. */
export function itinerary(tour: Tour, places: readonly Place[]): Itinerary {
  const known = (id: string) => places.some((place) => place.id === id);
  const home = tour.home !== null && known(tour.home) ? [{ stop: null, place: tour.home }] : [];
  const stops = tour.stops.filter((stop) => !stop.left_out);
  const there = stops.filter(({ place }) => known(place)).map(({ id, place }) => ({ stop: id, place }));
  const all = there.length > 0 ? [...home, ...there, ...home] : [];
  const lacking = stops
    .filter(({ place }) => !known(place))
    .map(({ id, place }) => none(id, t("there is no place {place} on the map", { place })));
  if (tour.home !== null && home.length === 0)
    lacking.push(none(null, t("there is no place {home} on the map", { home: tour.home })));
  return {
    points: all.map(({ place }) => ({ place })),
    to: all.slice(1).map(({ stop }) => stop),
    lacking,
  };
}

/** The legs in the order of the tour. */
export function legsOf(tour: Tour, { to, lacking }: Itinerary, route: RouteReport | null): Leg[] {
  const planned = (route?.legs ?? []).map((leg, at): Leg => ({ ...leg, stop: to[at] ?? null }));
  const order = [...tour.stops.map(({ id }): string | null => id), null];
  return [...planned, ...lacking].sort((a, b) => order.indexOf(a.stop) - order.indexOf(b.stop));
}

/** "12 m, 0.5 min"; without a way, why. */
export function legWords({ state, reason, length_m, duration_s }: Leg): string {
  const long = `${number(length_m, length_m < 10 ? 1 : 0)} m, ${minutes(duration_s)}`;
  if (state === "none") return t("Cannot be driven: {reason}", { reason });
  if (state === "near") return t("{long}, but {reason}", { long, reason });
  return reason ? `${long}; ${reason}` : long;
}

/** The whole tour: how far, how long on the way and in speech, and how many legs cannot be driven. */
export function tourWords(tour: Tour, legs: readonly Leg[]): { text: string; blocked: number } {
  const driven = legs.filter(({ state }) => state !== "none");
  const sum = (of: (leg: Leg) => number) => driven.reduce((total, leg) => total + of(leg), 0);
  const driving_s = sum((leg) => leg.duration_s);
  const speech_s = speechOf(tour);
  const parts = [
    `${number(
      sum((leg) => leg.length_m),
      0,
    )} m`,
    t("{time} of driving", { time: minutes(driving_s) }),
  ];
  if (speech_s > 0) parts.push(t("{time} of speech", { time: minutes(speech_s) }));
  return {
    text: t("{parts}: about {whole}", { parts: parts.join(", "), whole: minutes(driving_s + speech_s) }),
    blocked: legs.length - driven.length,
  };
}

/** How long the robot speaks on it, in the first language (s), about; waiting and answers not counted. */
export function speechOf(tour: Tour): number {
  const stops = tour.stops.filter((stop) => !stop.left_out);
  const steps = [...tour.greeting.do, ...stops.flatMap((stop) => stop.do), ...tour.farewell.do];
  return steps.reduce((total, step) => total + saidOf(step, tour.languages[0] ?? "en"), 0) / WORDS_S;
}

function saidOf({ say }: Step, language: string): number {
  return say?.[language]?.split(/\s+/).filter((word) => word !== "").length ?? 0;
}

function minutes(seconds: number): string {
  return seconds < 50
    ? `${Math.round(seconds)} s`
    : t("{minutes} min", { minutes: number(seconds / 60, seconds < 570 ? 1 : 0) });
}

function none(stop: string | null, reason: string): Leg {
  return { stop, state: "none", reason, length_m: 0, duration_s: 0, path: [] };
}
