/** Two presses of one key in quick succession; pure. */

export const WITHIN_MS = 600;

export class DoublePress {
  private lastAt = Number.NEGATIVE_INFINITY;

  /** A press at `at` (ms); whether it is the second of two. A third is the first of the next two. */
  press(at: number): boolean {
    const second = at - this.lastAt <= WITHIN_MS;
    this.lastAt = second ? Number.NEGATIVE_INFINITY : at;
    return second;
  }
}
