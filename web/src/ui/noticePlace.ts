/** Where a notice is shown: where it covers nothing that can be pressed, as near as can be to where it is looked for. Pure. */

export interface Box {
  left: number;
  top: number;
  width: number;
  height: number;
}
/** `weight`: how bad it is to cover it, per pixel; a notice goes as many pixels further instead. */
export interface Obstacle extends Box {
  weight: number;
}
export interface Size {
  width: number;
  height: number;
}

const STEP = 8;
/** Kept free around everything. */
const GAP = 4;
/** Of a cover, however small: what is touched at all is harder to press. */
const TOUCHED = 4000;
/** A narrower notice has more lines: as bad as so many pixels further away. */
const NARROWER = 60;

/** How bad a notice at `box` is for what it covers. 0: it covers nothing. */
export function covers(box: Box, obstacles: readonly Obstacle[]): number {
  let sum = 0;
  for (const each of obstacles) {
    const across = Math.min(box.left + box.width, each.left + each.width + GAP) - Math.max(box.left, each.left - GAP);
    const down = Math.min(box.top + box.height, each.top + each.height + GAP) - Math.max(box.top, each.top - GAP);
    if (across > 0 && down > 0) sum += each.weight * (TOUCHED + across * down);
  }
  return sum;
}

/**
 * The best box of one of `sizes` (widest first) within `room`: its upper edge's middle near `wanted`. All in CSS pixels
 * of the window. Sizes that are larger than the room are cut to it.
 */
export function placed(
  sizes: readonly Size[],
  room: Box,
  wanted: { x: number; y: number },
  obstacles: readonly Obstacle[],
): Box {
  let best: Box = { ...room, width: 0, height: 0 };
  let least = Infinity;
  sizes.forEach((size, narrower) => {
    const width = Math.min(size.width, room.width);
    const height = Math.min(size.height, room.height);
    for (const top of steps(room.top, room.top + room.height - height, wanted.y))
      for (const left of steps(room.left, room.left + room.width - width, wanted.x - width / 2)) {
        const box = { left, top, width, height };
        const away = Math.hypot(left + width / 2 - wanted.x, top - wanted.y) + narrower * NARROWER;
        if (away >= least) continue;
        const cost = away + covers(box, obstacles);
        if (cost < least) [best, least] = [box, cost];
      }
  });
  return best;
}

/** From `first` to `last`, in steps, and what is nearest to `wanted`. */
function steps(first: number, last: number, wanted: number): number[] {
  const all = [Math.max(first, Math.min(last, wanted))];
  for (let at = first; at < last; at += STEP) all.push(at);
  all.push(last);
  return all;
}
