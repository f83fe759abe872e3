/** Which stretch of time the lanes show: pure functions for zoom, pan and pause. */

import { t } from "../i18n";

export const SHORTEST_S = 10;
export const LONGEST_S = 3600;
export const DEFAULT_S = 30;
/** The right edge trails the robot's clock, so that what belongs there has arrived and is drawn, four times a second. */
export const TRAIL_S = 0.5;

export interface Viewport {
  windowS: number;
  /** Stamp of the right edge while paused; null: live. */
  heldAt: number | null;
}

export const INITIAL: Viewport = { windowS: DEFAULT_S, heldAt: null };
const STEPS = [10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600];

export function edges(view: Viewport, now: number, trail = TRAIL_S): { from: number; to: number } {
  const to = view.heldAt ?? now - trail;
  return { from: to - view.windowS, to };
}

/** Zooms by `factor` (over 1: closer). While paused the time at `share` of the width (0 left, 1 right) stays in place. */
export function zoom(view: Viewport, factor: number, share = 1): Viewport {
  const windowS = clamp(view.windowS / factor, SHORTEST_S, LONGEST_S);
  if (view.heldAt === null) return { windowS, heldAt: null };
  const anchor = view.heldAt - view.windowS * (1 - share);
  return { windowS, heldAt: anchor + windowS * (1 - share) };
}

/** The next wider (1) or closer (−1) of the usual windows. */
export function stepZoom(view: Viewport, direction: 1 | -1): Viewport {
  const next =
    direction > 0 ? STEPS.find((s) => s > view.windowS + 0.01) : STEPS.findLast((s) => s < view.windowS - 0.01);
  return { ...view, windowS: next ?? (direction > 0 ? LONGEST_S : SHORTEST_S) };
}

/** Moves the view by `seconds` into the past (positive); holds it, and lets go again at the present. */
export function pan(view: Viewport, seconds: number, now: number, oldest: number): Viewport {
  const live = now - TRAIL_S;
  const to = (view.heldAt ?? live) - seconds;
  if (to >= live) return { ...view, heldAt: null };
  return { ...view, heldAt: Math.max(to, Math.min(live, oldest + view.windowS * 0.25)) };
}

export function togglePause(view: Viewport, now: number): Viewport {
  return { ...view, heldAt: view.heldAt === null ? now - TRAIL_S : null };
}

/** Distance between ticks of the time axis, so that at most `most` fit. */
export function tickStep(windowS: number, most: number): number {
  return [1, 2, 5, 10, 15, 30, 60, 120, 300, 600].find((s) => windowS / s <= most) ?? 900;
}

export function span(seconds: number): string {
  return seconds < 60 ? `${Math.round(seconds)} s` : t("{minutes} min", { minutes: Number((seconds / 60).toFixed(1)) });
}

function clamp(value: number, low: number, high: number): number {
  return Math.max(low, Math.min(high, value));
}

/**
 * Where something `high` begins that is about the row from `from` to `to`: over it or under it, within `top` and
 * `bottom`; where neither has the room, as near as the foot allows, but never over `top`.
 */
export function placeBeside(from: number, to: number, high: number, top: number, bottom: number): number {
  if (from - high >= top) return from - high;
  return Math.max(top, Math.min(to, bottom - high));
}

export interface Tick {
  /** Of the width: 0 left, 1 right. */
  share: number;
  label: string;
}

/** About the width of a letter of the axis, and of half a label with the room beside it (CSS pixels). */
const LETTER_PX = 6.5;
const HALF_LABEL_PX = 26;

/** The ticks of an axis over `windowS` and `width` (CSS pixels), from its right edge on, which is called `edge`. */
export function ticks(windowS: number, width: number, edge: string): Tick[] {
  const every = tickStep(windowS, Math.max(2, Math.floor(width / 70)));
  const found: Tick[] = [{ share: 1, label: edge }];
  for (let s = every; s <= windowS; s += every) {
    const share = 1 - s / windowS;
    // The label is centred on its line, and has to have room on its left.
    if (share * width < 20) continue;
    // Nor may it run into the edge's, which ends there.
    const room = (1 - share) * width >= LETTER_PX * edge.length + HALF_LABEL_PX;
    const label = every >= 60 ? t("−{minutes} min", { minutes: s / 60 }) : `−${s} s`;
    found.push({ share, label: room ? label : "" });
  }
  return found;
}
