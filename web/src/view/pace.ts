/**
 * How finely the 3D view is drawn. Where a computer draws it slowly (no graphics card), what shares its thread or its
 * processor suffers, so it is drawn smaller and stretched. Pure; steps down only, so that it never swings.
 */

/** Shares of the full resolution, each way. */
export const SHARES = [1, 0.7, 0.5] as const;
/** Windows in a row that must be slow: loading the view is no measure. */
const PATIENCE = 2;
const SLOW_MS = 70;

export interface Pace {
  step: number;
  slow: number;
}

export const FULL: Pace = { step: 0, slow: 0 };

/** Drawn as small as it gets, and slow all the same. */
export function hopeless(pace: Pace): boolean {
  return pace.step === SHARES.length - 1 && pace.slow > PATIENCE;
}

/** A window of two seconds has passed, in which frames came every `frameMs`. */
export function paced(pace: Pace, frameMs: number): Pace {
  const slow = frameMs > SLOW_MS ? pace.slow + 1 : 0;
  if (slow < PATIENCE || pace.step >= SHARES.length - 1) return { ...pace, slow };
  return { step: pace.step + 1, slow: 0 };
}
