/** Samples of one lane brought down to pixel columns: what is drawn is bounded by the width, not by the history. */

import type { LaneHistory } from "./history";

/** Per column its place and the least, greatest, last and mean value; `end` is where the last value stops holding. */
export class Columns {
  readonly x: Float32Array;
  readonly end: Float32Array;
  readonly low: Float32Array;
  readonly high: Float32Array;
  readonly last: Float32Array;
  readonly mean: Float32Array;
  length = 0;

  constructor(width: number) {
    const size = Math.max(8, Math.ceil(width) + 4);
    this.x = new Float32Array(size);
    this.end = new Float32Array(size);
    this.low = new Float32Array(size);
    this.high = new Float32Array(size);
    this.last = new Float32Array(size);
    this.mean = new Float32Array(size);
  }
}

export interface Span {
  /** Stamps at the left and right edges. */
  from: number;
  to: number;
  /** Width in device pixels. */
  width: number;
}

/**
 * Fills `out` with the columns of `values` that are visible in `span`, left to right. A sample holds until the next;
 * NaN and silences longer than a sample holds leave a hole (the column before ends early). `bounds`: the least and the
 * greatest of what a value stands for.
 */
export function toColumns(
  history: LaneHistory,
  values: Float32Array,
  span: Span,
  out: Columns,
  bounds: { low: Float32Array; high: Float32Array } = { low: values, high: values },
): void {
  out.length = 0;
  const perSecond = span.width / (span.to - span.from);
  const start = Math.max(history.first, history.at(span.from));
  const stop = history.at(span.to);
  let column = -1;
  let weight = 0;
  for (let number = start; number <= stop && number >= 0; number++) {
    const slot = number % history.capacity;
    const value = values[slot]!;
    if (Number.isNaN(value)) continue;
    const stamp = history.stamps[slot]!;
    const next = number + 1 < history.count ? history.stamps[(number + 1) % history.capacity]! : Infinity;
    const held = Math.min(next, stamp + history.holds[slot]!);
    if (held <= span.from) continue;
    const x = Math.max(0, (stamp - span.from) * perSecond);
    const end = Math.min(span.width, (held - span.from) * perSecond);
    const here = Math.floor(x);
    const at = out.length - 1;
    if (here === column && at >= 0) {
      weight += 1;
      out.low[at] = Math.min(out.low[at]!, bounds.low[slot]!);
      out.high[at] = Math.max(out.high[at]!, bounds.high[slot]!);
      out.mean[at] = out.mean[at]! + (value - out.mean[at]!) / weight;
      out.last[at] = value;
      out.end[at] = end;
    } else if (out.length < out.x.length) {
      column = here;
      weight = 1;
      out.x[out.length] = x;
      out.end[out.length] = end;
      out.low[out.length] = bounds.low[slot]!;
      out.high[out.length] = bounds.high[slot]!;
      out.last[out.length] = out.mean[out.length] = value;
      out.length += 1;
    }
  }
}
