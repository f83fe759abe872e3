/** The lanes further back than the page has heard them: asked for as far and as finely as they are shown. */

import type { LaneRow, LanesPast, RobotEvent } from "../protocol/types";
import { GAP_S, LaneHistory } from "./history";
import type { Edges } from "./strip";
import { LONGEST_S } from "./viewport";

/** The robot answers with at most so many buckets. */
const MOST_POINTS = 1200;
/** So much wider than the view, on each side, is what is asked for: it is there when the view is moved. */
const MARGIN = 0.5;
/** Buckets may be so much coarser than the columns that they are drawn in, before finer ones are asked for. */
const COARSE = 2;
/** After a refusal, or a view that has moved while an answer was under way. */
const AGAIN_MS = 3000;

export interface Ask extends Edges {
  points: number;
}

/** What was answered to an ask. */
export interface Answer {
  ask: Ask;
  bucketS: number;
  history: LaneHistory;
  events: readonly RobotEvent[];
}

/**
 * What to ask for, so that `edges` can be shown in `columns`: null where all of it was heard live, since `heard`, or is
 * in the `answer`. `now`: the robot's clock.
 */
export function wanted(edges: Edges, columns: number, heard: number, now: number, answer: Answer | null): Ask | null {
  const to = Math.min(edges.to, heard);
  if (edges.from >= to) return null;
  const windowS = edges.to - edges.from;
  if (answer) {
    const covers = answer.ask.from <= edges.from && to <= answer.ask.to;
    if (covers && answer.bucketS <= (COARSE * windowS) / Math.min(columns, MOST_POINTS)) return null;
  }
  const from = Math.max(edges.from - MARGIN * windowS, now - LONGEST_S * (1 + MARGIN));
  const until = Math.min(edges.to + MARGIN * windowS, now);
  const points = Math.ceil((Math.min(columns, MOST_POINTS) * (until - from)) / windowS);
  return { from: Math.min(from, edges.from), to: until, points: Math.max(2, Math.min(MOST_POINTS, points)) };
}

/** `past` as the lanes are drawn from: a sample at each bucket and each change. */
export function historyOf(past: LanesPast): LaneHistory {
  const stamps = new Set(past.stamps);
  for (const row of past.rows) for (const { stamp } of row.changes) stamps.add(stamp);
  const all = [...stamps].sort((a, b) => a - b);
  const made = new LaneHistory(Math.max(1, all.length));
  const next = past.rows.map(() => 0);
  let bucket = 0;
  for (const stamp of all) {
    while (bucket + 1 < past.stamps.length && past.stamps[bucket + 1]! <= stamp) bucket += 1;
    const rows = past.rows.flatMap((row, index) => {
      while (row.changes[next[index]! + 1] && row.changes[next[index]! + 1]!.stamp <= stamp) next[index]! += 1;
      const change = row.changes[next[index]!];
      return change ? [{ ...change, class: row.class, rate: row.rate[bucket] ?? null } as LaneRow] : [];
    });
    const slot = made.count;
    made.push({ stamp, rows }, past.ends[bucket]! - stamp + GAP_S);
    // Where each sample is a bucket, it is the least and greatest itself.
    for (const row of past.bucket_s > 0 ? past.rows : []) {
      const lane = made.lanes.get(row.class);
      if (!lane) continue;
      if (lane.low === lane.rate) [lane.low, lane.high] = [lane.rate.slice(), lane.rate.slice()];
      lane.low[slot] = row.low[bucket] ?? NaN;
      lane.high[slot] = row.high[bucket] ?? NaN;
    }
  }
  return made;
}

/** `past` up to where `heard` begins, and that: one history from `from` to `to`. */
export function joined(past: LaneHistory, heard: LaneHistory, { from, to }: Edges): LaneHistory {
  const seam = heard.count > 0 ? heard.oldest : Infinity;
  const pieces: [LaneHistory, number][] = [];
  for (const of of [past, heard])
    for (let number = Math.max(of.first, of.at(from)); number >= 0 && number <= of.at(to); number++)
      if (of === heard || of.stamps[number % of.capacity]! < seam) pieces.push([of, number]);
  const made = new LaneHistory(Math.max(1, pieces.length));
  for (const [of, number] of pieces) {
    const slot = number % of.capacity;
    made.push({ stamp: of.stamps[slot]!, rows: of.rowsAt(number) }, of.holds[slot]);
  }
  return made;
}

interface Source {
  lanes(ask: Ask): Promise<LanesPast>;
  events(edges: Edges): Promise<RobotEvent[]>;
}

/** Asks for what is shown, one thing at a time; meanwhile what is there stays. */
export class Past {
  answer: Answer | null = null;
  /** Stamp of the oldest sample that the robot keeps; null: not known, or none. */
  oldest: number | null = null;
  private waiting = false;
  private again = 0;
  private generation = 0;

  constructor(
    private readonly source: Source,
    private readonly came: (answer: Answer) => void,
  ) {}

  /** Another time is recalled: nothing of the old one is of use. */
  clear(): void {
    this.answer = null;
    this.oldest = null;
    this.generation += 1;
    this.again = 0;
  }

  /** `ms`: the page's clock. */
  async show(ask: Ask | null, ms: number): Promise<void> {
    if (!ask || this.waiting || ms < this.again) return;
    this.waiting = true;
    const { generation } = this;
    try {
      const [past, events] = await Promise.all([this.source.lanes(ask), this.source.events(ask)]);
      if (generation !== this.generation) return;
      this.oldest = past.oldest;
      this.answer = { ask, bucketS: past.bucket_s, history: historyOf(past), events };
      this.came(this.answer);
    } catch {
      // The link is down, or the robot is another: what is there is shown.
      this.again = ms + AGAIN_MS;
    } finally {
      this.waiting = false;
    }
  }
}
