/** Where names go on the strip of all directions: near their marks, and over nothing else. Pure. */

import type { Box } from "./layer";
import type { Strip } from "./stripProjection";

/** From over a mark to under it, px at the least. */
const BELOW = 16;
/** px between a name and what it keeps off. */
const GAP = 1;

/**
 * Where a name of `size` goes that is wanted above `bottom`, its middle at `x`: there, or the nearest place that is
 * over none of `taken`; null: there is none. `bounds` is the part of the strip that it may lie on.
 */
export function freePlace(
  size: Strip,
  at: { x: number; bottom: number },
  bounds: Strip,
  taken: readonly Box[],
): Box | null {
  const { width, height } = size;
  const wanted = wantedPlace(size, at, bounds);
  const under = fit(at.bottom + BELOW, height, bounds.height);
  const columns = [wanted.x, ...taken.flatMap((box) => [box.x - width - GAP, box.x + box.width + GAP])];
  const rows = [wanted.y, under, ...taken.flatMap((box) => [box.y - height - GAP, box.y + box.height + GAP])];
  const away = (box: Box) => Math.abs(box.x - wanted.x) + Math.abs(box.y - wanted.y);
  return columns
    .flatMap((left) => rows.map((top) => ({ x: left, y: top, width, height })))
    .filter((box) => isWithin(box, bounds) && !taken.some((other) => overlap(box, other)))
    .reduce<Box | null>((best, box) => (best && away(best) <= away(box) ? best : box), null);
}

/** Where it is wanted, as far as `bounds` let it. */
function wantedPlace({ width, height }: Strip, { x, bottom }: { x: number; bottom: number }, bounds: Strip): Box {
  return { x: fit(x - width / 2, width, bounds.width), y: fit(bottom - height, height, bounds.height), width, height };
}

/**
 * The place of the first of `sizes`, the longest name first, for which one is free; of the last where it was wanted, over
 * what may be there, if there is none.
 */
export function namePlace<Name extends Strip>(
  sizes: readonly [Name, ...Name[]],
  at: { x: number; bottom: number },
  bounds: Strip,
  taken: readonly Box[],
): { name: Name; box: Box } {
  for (const name of sizes) {
    const box = freePlace(name, at, bounds, taken);
    if (box) return { name, box };
  }
  const name = sizes.at(-1)!;
  return { name, box: wantedPlace(name, at, bounds) };
}

function fit(from: number, length: number, most: number): number {
  return Math.max(GAP, Math.min(most - length - GAP, from));
}

export function overlap(a: Box, b: Box): boolean {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

function isWithin(box: Box, { width, height }: Strip): boolean {
  return box.x >= 0 && box.y >= 0 && box.x + box.width <= width && box.y + box.height <= height;
}
