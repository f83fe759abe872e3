/** What the lanes showed: one bounded ring of stamps, one column of values per class; the newest ten minutes, or a past. */

import type { Divisors, LaneRow, LaneState, LanesHistory } from "../protocol/types";
import { sameDivisors } from "./rows";

/** Up to 20 messages a second for 10 minutes and a little. */
export const CAPACITY = 12_600;
/** Further apart than this, nothing was heard in between. */
export const GAP_S = 1;
/** A clock set back by more than this clears the history. */
const SET_BACK_S = 5;

export interface LaneSample {
  stamp: number;
  intensity: number | null;
  utility: number | null;
  rate: number | null;
  divisor: number | null;
  divisors: Divisors;
  state: LaneState;
  text: string;
}

const NO_DIVISORS: Divisors = {};

/** Values of one class by slot; NaN where there is none. */
export class Lane {
  readonly intensity: Float32Array;
  readonly utility: Float32Array;
  readonly rate: Float32Array;
  /** Least and greatest rate until the next sample: the rate itself, but of a past in buckets. */
  low: Float32Array;
  high: Float32Array;
  readonly divisor: Float32Array;
  readonly divisors: (Divisors | undefined)[];
  readonly state: (LaneState | undefined)[];
  readonly text: (string | undefined)[];
  /** Stamp of the newest sample at which it was desired, or needed. */
  desired = -Infinity;

  constructor(capacity: number) {
    const values = () => new Float32Array(capacity).fill(NaN);
    [this.intensity, this.utility, this.rate, this.divisor] = [values(), values(), values(), values()];
    this.low = this.high = this.rate;
    this.divisors = new Array(capacity);
    this.state = new Array(capacity);
    this.text = new Array(capacity);
  }
}

export class LaneHistory {
  readonly stamps: Float64Array;
  /** How long each sample holds where no other follows: longer in a recording that runs faster than life. */
  readonly holds: Float32Array;
  readonly lanes = new Map<string, Lane>();
  /** How many samples were ever pushed; the newest has the number `count − 1`. */
  count = 0;
  /** How often it began without a past: what was drawn of another is void. */
  generation = 0;

  constructor(readonly capacity = CAPACITY) {
    this.stamps = new Float64Array(capacity);
    this.holds = new Float32Array(capacity);
  }

  /** The oldest sample number still kept. */
  get first(): number {
    return Math.max(0, this.count - this.capacity);
  }

  get newest(): number | null {
    return this.count > 0 ? this.stamps[(this.count - 1) % this.capacity]! : null;
  }

  /** The stamp of the oldest sample kept; 0 while there is none. */
  get oldest(): number {
    return this.count > 0 ? this.stamps[this.first % this.capacity]! : 0;
  }

  push(message: { stamp: number; rows: LaneRow[] }, holdS = GAP_S): void {
    const newest = this.newest;
    if (newest !== null && message.stamp <= newest) {
      if (newest - message.stamp < SET_BACK_S) return;
      this.clear();
    }
    const slot = this.count % this.capacity;
    this.stamps[slot] = message.stamp;
    this.holds[slot] = holdS;
    for (const lane of this.lanes.values()) blank(lane, slot);
    for (const row of message.rows) this.write(row, slot, message.stamp);
    this.count += 1;
  }

  /**
   * Takes the past that the robot sends on a new connection: all of it, or after a break what this page has missed. Of a
   * robot whose clock was set back, the new past alone is kept.
   */
  fill(past: LanesHistory, holdS = GAP_S): void {
    const last = past.stamps.at(-1);
    if (last === undefined) return;
    if (this.newest !== null && this.newest - last >= SET_BACK_S) this.clear();
    const heard = this.newest ?? -Infinity;
    const spells = past.rows.map(() => -1);
    past.stamps.forEach((stamp, number) => {
      const rows = past.rows.flatMap((row, index) => {
        while (row.spells[spells[index]! + 1] && row.spells[spells[index]! + 1]!.at <= number) spells[index]! += 1;
        const spell = row.spells[spells[index]!];
        if (!spell) return [];
        const { intensity, utility, divisor, divisors, state, text } = spell;
        const rate = row.rate[number] ?? null;
        return [{ class: row.class, rate, intensity, utility, divisor, divisors, state, text } as LaneRow];
      });
      if (stamp > heard) this.push({ stamp, rows }, holdS);
    });
  }

  /** The number of the newest sample not after `stamp`; `first − 1` if all are after it. */
  at(stamp: number): number {
    let low = this.first - 1;
    let high = this.count - 1;
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.stamps[middle % this.capacity]! <= stamp) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** What each lane showed at sample `number`. */
  rowsAt(number: number): LaneRow[] {
    const slot = number % this.capacity;
    return [...this.lanes].flatMap(([name, lane]) => {
      const state = lane.state[slot];
      if (state === undefined) return [];
      const [intensity, utility, rate, divisor] = [lane.intensity, lane.utility, lane.rate, lane.divisor].map((of) =>
        orNull(of[slot]!),
      ) as [number | null, number | null, number | null, number | null];
      const divisors = lane.divisors[slot] ?? NO_DIVISORS;
      return [{ class: name, intensity, utility, rate, divisor, divisors, state, text: lane.text[slot] ?? "" }];
    });
  }

  /** What `name` showed at `stamp`; null where nothing was heard. */
  sample(name: string, stamp: number): LaneSample | null {
    const lane = this.lanes.get(name);
    const number = this.at(stamp);
    if (!lane || number < this.first || number < 0) return null;
    const slot = number % this.capacity;
    const state = lane.state[slot];
    if (state === undefined || stamp - this.stamps[slot]! > this.holds[slot]!) return null;
    return {
      stamp: this.stamps[slot]!,
      intensity: orNull(lane.intensity[slot]!),
      utility: orNull(lane.utility[slot]!),
      rate: orNull(lane.rate[slot]!),
      divisor: orNull(lane.divisor[slot]!),
      divisors: lane.divisors[slot] ?? NO_DIVISORS,
      state,
      text: lane.text[slot] ?? "",
    };
  }

  /** Whether `name` was desired, or needed, at `stamp` or later. */
  desiredSince(name: string, stamp: number): boolean {
    return (this.lanes.get(name)?.desired ?? -Infinity) >= stamp;
  }

  clear(): void {
    this.generation += 1;
    this.count = 0;
    this.lanes.clear();
  }

  private write(row: LaneRow, slot: number, stamp: number): void {
    let lane = this.lanes.get(row.class);
    if (!lane) {
      lane = new Lane(this.capacity);
      this.lanes.set(row.class, lane);
    }
    lane.intensity[slot] = row.intensity ?? NaN;
    lane.utility[slot] = row.utility ?? NaN;
    lane.rate[slot] = row.rate ?? NaN;
    lane.divisor[slot] = row.divisor ?? NaN;
    lane.state[slot] = row.state;
    if (row.state !== "undesired") lane.desired = stamp;
    // What stays the same is shared, so that ten minutes of one reason are kept once.
    const last = (slot + this.capacity - 1) % this.capacity;
    const before = lane.text[last];
    lane.text[slot] = before === row.text ? before : row.text;
    const known = lane.divisors[last];
    lane.divisors[slot] = known && sameDivisors(known, row.divisors) ? known : row.divisors;
  }
}

function blank(lane: Lane, slot: number): void {
  lane.intensity[slot] = lane.utility[slot] = lane.rate[slot] = lane.divisor[slot] = NaN;
  lane.state[slot] = undefined;
  lane.text[slot] = undefined;
  lane.divisors[slot] = undefined;
}

function orNull(value: number): number | null {
  return Number.isNaN(value) ? null : value;
}
