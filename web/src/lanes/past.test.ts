import { expect, test } from "vitest";
import type { LanesPast } from "../protocol/types";
import { Columns, toColumns } from "./columns";
import { LaneHistory } from "./history";
import { type Answer, type Ask, historyOf, joined, Past, wanted } from "./past";
import { spells } from "./runLengths";

const NOW = 10_000;
const CHANGE = { intensity: 8, utility: 4, divisor: 2, divisors: {}, state: "fulfilled", text: "it fits" } as const;
const SHUT = { ...CHANGE, divisor: null, state: "unfulfilled", text: "it costs too much" } as const;

/** Two buckets of a minute; in the first, half a second of a closed filter. */
const PAST: LanesPast = {
  oldest: 6400,
  bucket_s: 60,
  stamps: [7000, 7060],
  ends: [7059.5, 7119.5],
  rows: [
    {
      class: "Explore",
      rate: [0.5, null],
      low: [0, null],
      high: [0.6, null],
      changes: [
        { ...CHANGE, stamp: 7000 },
        { ...SHUT, stamp: 7030 },
        { ...CHANGE, stamp: 7030.5 },
      ],
    },
  ],
};

const answer = (ask: Ask, bucketS = 0): Answer => ({ ask, bucketS, history: historyOf(PAST), events: [] });

test("what was heard live is not asked for", () => {
  expect(wanted({ from: 9500, to: 10_000 }, 1000, 9400, NOW, null)).toBeNull();
  expect(wanted({ from: 9400, to: 9500 }, 1000, 9400, NOW, null)).toBeNull();
});

test("what is shown is asked for with a margin, and no finer than it is drawn", () => {
  const hour = wanted({ from: 6400, to: 10_000 }, 800, 9400, NOW, null);
  expect(hour).toEqual({ from: 4600, to: 10_000, points: 1200 });
  expect(wanted({ from: 8000, to: 8010 }, 200, 9400, NOW, null)).toEqual({ from: 7995, to: 8015, points: 400 });
  // Wide as a wall, the answer is still bounded.
  expect(wanted({ from: 6400, to: 10_000 }, 8000, 9400, NOW, null)!.points).toBe(1200);
});

test("an answer serves while it covers the view and is fine enough", () => {
  const wide = answer({ from: 4600, to: 10_000, points: 1200 }, 4.5);
  expect(wanted({ from: 6400, to: 10_000 }, 800, 9400, NOW, wide)).toBeNull();
  // Time goes on, and what was heard live is forgotten: until the view needs what came after the answer.
  expect(wanted({ from: 6460, to: 10_060 }, 800, 9460, 10_060, wide)).toBeNull();
  expect(wanted({ from: 7500, to: 11_100 }, 800, 10_100, 11_100, wide)).not.toBeNull();
  // Closer, it is too coarse.
  expect(wanted({ from: 7000, to: 7060 }, 800, 9400, NOW, wide)).not.toBeNull();
  expect(wanted({ from: 7000, to: 7060 }, 800, 9400, NOW, answer({ from: 6970, to: 7090, points: 1200 }))).toBeNull();
  expect(
    wanted({ from: 6960, to: 7020 }, 800, 9400, NOW, answer({ from: 6970, to: 7090, points: 1200 })),
  ).not.toBeNull();
});

test("a past in buckets shows the least and greatest rate, and the closing that is shorter than a bucket", () => {
  const history = historyOf(PAST);
  const columns = new Columns(40);
  const lane = history.lanes.get("Explore")!;
  toColumns(history, lane.rate, { from: 6990, to: 7190, width: 20 }, columns, lane);
  expect(columns.low[0]).toBe(0);
  expect(columns.high[0]).toBeCloseTo(0.6, 6);
  expect(columns.last[0]).toBeCloseTo(0.5, 6);
  const seen: [string, number, number][] = [];
  spells(history, lane, { from: 6990, to: 7190 }, (state, from, to) => seen.push([state, from, to]));
  expect(seen).toEqual([
    ["fulfilled", 7000, 7030],
    ["unfulfilled", 7030, 7030.5],
    ["fulfilled", 7030.5, 7120.5],
  ]);
  expect(history.sample("Explore", 7030.2)).toMatchObject({ state: "unfulfilled", text: "it costs too much" });
  // After the end of the last bucket nothing is known.
  expect(history.sample("Explore", 7121)).toBeNull();
});

test("where every sample is there, it is its own least and greatest", () => {
  const row = { ...PAST.rows[0]!, rate: [0.5, 0.25], low: [], high: [], changes: [{ ...CHANGE, stamp: 7000 }] };
  const history = historyOf({ ...PAST, bucket_s: 0, stamps: [7000, 7000.5], ends: [7000, 7000.5], rows: [row] });
  const lane = history.lanes.get("Explore")!;
  expect([lane.low[0], lane.high[1], lane.rate[1]]).toEqual([0.5, 0.25, 0.25]);
});

test("past and present join where the page began to hear", () => {
  const heard = new LaneHistory();
  for (const stamp of [7060, 7060.5])
    heard.push({ stamp, rows: [{ ...SHUT, class: "Explore", rate: 0, divisors: {} }] });
  const all = joined(historyOf(PAST), heard, { from: 7001, to: 7100 });
  expect(Array.from(all.stamps)).toEqual([7000, 7030, 7030.5, 7060, 7060.5]);
  expect(all.sample("Explore", 7031)).toMatchObject({ state: "fulfilled", divisor: 2 });
  expect(all.sample("Explore", 7060.2)).toMatchObject({ state: "unfulfilled", divisor: null });
});

test("one answer is waited for at a time, a refusal is not asked again at once, and another time voids it", async () => {
  const asked: Ask[] = [];
  let refuse = false;
  let came = 0;
  const past = new Past(
    {
      lanes: async (ask) => {
        asked.push(ask);
        if (refuse) throw new Error("the link is down");
        return PAST;
      },
      events: async () => [],
    },
    () => (came += 1),
  );
  const ask = { from: 1, to: 2, points: 3 };
  await past.show(null, 0);
  const first = past.show(ask, 0);
  await past.show(ask, 0);
  await first;
  expect([asked.length, came, past.oldest]).toEqual([1, 1, 6400]);
  refuse = true;
  await past.show(ask, 10);
  await past.show(ask, 20);
  expect([asked.length, came]).toEqual([2, 1]);
  expect(past.answer).not.toBeNull();
  refuse = false;
  const late = past.show(ask, 60_000);
  past.clear();
  await late;
  expect([asked.length, came, past.answer]).toEqual([3, 1, null]);
});
