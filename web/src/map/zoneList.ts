/** Keep-out and speed zones as a list that is edited: every function returns a new list. Pure. */

import { t } from "../i18n";
import type { Zone } from "../protocol/types";
import type { Point } from "./mapProjection";

export type ZoneKind = Zone["kind"];

/** m². */
const LEAST_AREA = 0.01;
const LEAST_SPEED = 0.05;
export const FIRST_SPEED = 0.4;
const UNDO_STEPS = 50;

/** What was, and what the last edit made of it: another page's edit in between is not undone. */
export interface History {
  readonly past: readonly (readonly Zone[])[];
  readonly made: readonly Zone[] | null;
}

export const NO_HISTORY: History = { past: [], made: null };

export function added(zones: readonly Zone[], kind: ZoneKind, polygon: readonly Point[]): Zone[] {
  const corners = polygon.map(({ x, y }): [number, number] => [round(x), round(y)]);
  const speed = kind === "slow" ? FIRST_SPEED : 1;
  return [
    ...zones,
    { name: freeName(zones, kind === "slow" ? t("Slow|name") : t("Keep out|name")), kind, polygon: corners, speed },
  ];
}

export function removed(zones: readonly Zone[], name: string): Zone[] {
  return zones.filter((zone) => zone.name !== name);
}

export function changed(zones: readonly Zone[], name: string, change: Partial<Omit<Zone, "polygon">>): Zone[] {
  return zones.map((zone) => (zone.name === name ? { ...zone, ...change } : zone));
}

export function cornerMoved(zones: readonly Zone[], name: string, index: number, to: Point): Zone[] {
  const move = (zone: Zone) =>
    zone.polygon.map((corner, i): [number, number] => (i === index ? [round(to.x), round(to.y)] : corner));
  return zones.map((zone) => (zone.name === name ? { ...zone, polygon: move(zone) } : zone));
}

/** What is wrong with a zone's new name; empty: nothing. */
export function nameProblem(zones: readonly Zone[], name: string, before: string): string {
  const trimmed = name.trim();
  if (trimmed === "") return t("A name is needed.");
  if (trimmed.length > 60) return t("At most 60 characters.");
  if (trimmed !== before && zones.some((zone) => zone.name === trimmed)) return t("Another zone has this name.");
  return "";
}

/** What is wrong with corners; empty: nothing. */
export function polygonProblem(polygon: readonly Point[]): string {
  if (polygon.length < 3) return t("A zone needs three corners at least.");
  if (Math.abs(area(polygon)) < LEAST_AREA) return t("That is too small for a zone.");
  if (crossesItself(polygon)) return t("The zone's border crosses itself: move its corners.");
  return "";
}

export function asSpeed(share: number): number {
  return Math.max(LEAST_SPEED, Math.min(1, Math.round(share * 20) / 20));
}

/** The topmost (last drawn) zone at a point. */
export function zoneAt(zones: readonly Zone[], point: Point): Zone | null {
  return zones.findLast((zone) => inside(cornersOf(zone), point)) ?? null;
}

export function cornersOf(zone: Zone): Point[] {
  return zone.polygon.map(([x, y]) => ({ x, y }));
}

/** Where a zone's name goes. */
export function middle(zone: Zone): Point {
  const corners = cornersOf(zone);
  const double = 2 * area(corners);
  if (Math.abs(double) < 1e-9) return corners[0] ?? { x: 0, y: 0 };
  let [x, y] = [0, 0];
  corners.forEach((a, i) => {
    const b = corners[(i + 1) % corners.length]!;
    const cross = a.x * b.y - b.x * a.y;
    x += (a.x + b.x) * cross;
    y += (a.y + b.y) * cross;
  });
  return { x: x / (3 * double), y: y / (3 * double) };
}

export function edited(history: History, before: readonly Zone[], after: readonly Zone[]): History {
  const past = isOurs(history, before) ? history.past : [];
  return { past: [...past, before].slice(-UNDO_STEPS), made: after };
}

/** The list before the last edit of ours; null: there is none, or another page has edited since. */
export function undoable(history: History, now: readonly Zone[]): readonly Zone[] | null {
  return isOurs(history, now) ? (history.past.at(-1) ?? null) : null;
}

export function undone(history: History): History {
  return { past: history.past.slice(0, -1), made: history.past.at(-1) ?? null };
}

function isOurs(history: History, now: readonly Zone[]): boolean {
  return history.made !== null && same(history.made, now);
}

export function same(a: readonly Zone[], b: readonly Zone[]): boolean {
  return (
    a.length === b.length &&
    a.every((zone, i) => {
      const other = b[i]!;
      return (
        zone.name === other.name &&
        zone.kind === other.kind &&
        Math.abs(zone.speed - other.speed) < 1e-6 &&
        zone.polygon.length === other.polygon.length &&
        zone.polygon.every(([x, y], k) => {
          const [ox, oy] = other.polygon[k]!;
          return Math.abs(x - ox) < 1e-6 && Math.abs(y - oy) < 1e-6;
        })
      );
    })
  );
}

export function inside(polygon: readonly Point[], point: Point): boolean {
  let within = false;
  polygon.forEach((a, i) => {
    const b = polygon[(i + 1) % polygon.length]!;
    if (a.y > point.y !== b.y > point.y && point.x < a.x + ((b.x - a.x) * (point.y - a.y)) / (b.y - a.y))
      within = !within;
  });
  return within;
}

function area(polygon: readonly Point[]): number {
  return polygon.reduce((sum, a, i) => {
    const b = polygon[(i + 1) % polygon.length]!;
    return sum + (a.x * b.y - b.x * a.y) / 2;
  }, 0);
}

function crossesItself(polygon: readonly Point[]): boolean {
  const count = polygon.length;
  for (let i = 0; i < count; i++)
    for (let k = i + 2; k < count; k++) {
      if (i === 0 && k === count - 1) continue;
      if (cross(polygon[i]!, polygon[i + 1]!, polygon[k]!, polygon[(k + 1) % count]!)) return true;
    }
  return false;
}

function cross(a: Point, b: Point, c: Point, d: Point): boolean {
  const side = (p: Point, q: Point, r: Point) => (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

function freeName(zones: readonly Zone[], stem: string): string {
  for (let number = 1; ; number++) {
    const name = `${stem} ${number}`;
    if (!zones.some((zone) => zone.name === name)) return name;
  }
}

/** To the centimetre: finer than any hand draws. */
function round(value: number): number {
  return Math.round(value * 100) / 100;
}
