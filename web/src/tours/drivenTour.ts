/** A tour that is configured by driving it once: posters that are met become stops, in this order; pure. */

import type { Landmark } from "../protocol/types";
import { type NewTour, newStop, newTour, posterTitle } from "./tourEdits";

/** A poster that was met. */
export interface Met {
  text: string;
  /** Its number on the map. */
  landmark: number;
  x: number;
  y: number;
}

export interface DrivenTour {
  title: string;
  language: string;
  /** How often each poster had been seen when it was looked at last; of those before the beginning, by then. */
  seen: Record<string, number>;
  met: Met[];
}

export function newDrivenTour(title: string, language: string, landmarks: readonly Landmark[]): DrivenTour {
  return { title, language, seen: sightings(landmarks), met: [] };
}

/** With what has been seen since. */
export function drivenOn(tour: DrivenTour, landmarks: readonly Landmark[]): DrivenTour {
  const fresh = landmarks.filter(
    (one) =>
      isPlaced(one) &&
      one.sightings > (tour.seen[keyOf(one)] ?? 0) &&
      !tour.met.some(({ text, landmark }) => text === one.text && landmark === one.id),
  );
  const seen = sightings(landmarks);
  if (fresh.length === 0 && Object.keys(seen).every((key) => tour.seen[key] === seen[key])) return tour;
  const order = fresh.toSorted((a, b) => a.last_seen - b.last_seen);
  const met = order.map(({ text, id, x, y }) => ({ text, landmark: id, x, y }));
  return { ...tour, seen: { ...tour.seen, ...seen }, met: [...tour.met, ...met] };
}

export function without(tour: DrivenTour, landmark: number): DrivenTour {
  return { ...tour, met: tour.met.filter((one) => one.landmark !== landmark) };
}

/** The tour; `places`: the id of the place before each poster, by the poster's number. */
export function tourOf(
  { title, language, met }: DrivenTour,
  map: string,
  taken: readonly string[],
  places: ReadonlyMap<number, string>,
): NewTour {
  const tour = newTour(title, language, map, taken);
  const posters = new Set<string>();
  for (const { text, landmark } of met) {
    const place = places.get(landmark);
    if (place === undefined) continue;
    // No two stops have one poster: of two that say the same, the second is a stop without.
    tour.stops.push(newStop(tour, place, posterTitle(text), posters.has(text) ? "" : text));
    posters.add(text);
  }
  return tour;
}

function sightings(landmarks: readonly Landmark[]): Record<string, number> {
  return Object.fromEntries(landmarks.filter(isPlaced).map((one) => [keyOf(one), one.sightings]));
}

function isPlaced({ frame }: Landmark): boolean {
  return frame === "map";
}

function keyOf({ text, id }: Pick<Landmark, "text" | "id">): string {
  return `${id} ${text}`;
}
