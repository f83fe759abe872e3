/**
 * How finely the 3D view is drawn. It shares the page's thread: where a computer draws it slowly (no graphics card), the
 * driving would suffer, so it is drawn smaller and stretched. Pure; steps down only, so that it never swings.
 */

/** Shares of the full resolution, each way. */
export const SHARES = [1, 0.7, 0.5] as const;
const WINDOW_MS = 2000;
/** Windows in a row that must be slow: loading the view is no measure. */
const PATIENCE = 2;
const SLOW_MS = 70;

export interface Pace {
  step: number;
  began: number;
  frames: number;
  slow: number;
}

/** Drawn as small as it gets, and slow all the same. */
export function hopeless(pace: Pace): boolean {
  return pace.step === SHARES.length - 1 && pace.slow > PATIENCE;
}

export function startPace(now: number, step = 0): Pace {
  return { step, began: now, frames: 0, slow: 0 };
}

/** One animation frame at `now` (ms). */
export function paced(pace: Pace, now: number): Pace {
  const frames = pace.frames + 1;
  const elapsed = now - pace.began;
  if (elapsed < WINDOW_MS) return { ...pace, frames };
  const slow = elapsed / frames > SLOW_MS ? pace.slow + 1 : 0;
  if (slow < PATIENCE || pace.step >= SHARES.length - 1) return { ...startPace(now, pace.step), slow };
  return startPace(now, pace.step + 1);
}
