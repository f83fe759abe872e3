import { describe, expect, test } from "vitest";
import type { LaneRow, LanesHistory } from "../protocol/types";
import { Columns, toColumns } from "./columns";
import { CAPACITY, LaneHistory } from "./history";
import { spells } from "./runLengths";
import {
  edges,
  INITIAL,
  LONGEST_S,
  pan,
  placeBeside,
  SHORTEST_S,
  stepZoom,
  TRAIL_S,
  ticks,
  togglePause,
  zoom,
} from "./viewport";

const START = 1_790_000_000;

function row(over: Partial<LaneRow> = {}): LaneRow {
  const [divisor, divisors] = [2, {}];
  return {
    class: "QR",
    intensity: 8,
    utility: 1,
    rate: 0.5,
    divisor,
    divisors,
    state: "fulfilled",
    text: "fits",
    ...over,
  };
}

function filled(count: number, make: (i: number) => LaneRow[]): LaneHistory {
  const history = new LaneHistory();
  for (let i = 0; i < count; i++) history.push({ stamp: START + i * 0.05, rows: make(i) });
  return history;
}

describe("history", () => {
  test("keeps the newest and forgets the rest", () => {
    const history = filled(CAPACITY + 500, (i) => [row({ intensity: i % 8 })]);
    expect(history.first).toBe(500);
    expect(history.sample("QR", START + 499 * 0.05)).toBeNull();
    expect(history.sample("QR", START + 500.5 * 0.05)!.intensity).toBe(500 % 8);
    expect(history.sample("QR", history.newest!)!.intensity).toBe((CAPACITY + 499) % 8);
    expect(history.lanes.get("QR")!.intensity.length).toBe(CAPACITY);
  });

  test("finds the sample that held at a time, in any place of the ring", () => {
    const history = filled(CAPACITY + 77, () => [row()]);
    for (const number of [77, 78, 5000, CAPACITY + 76]) {
      expect(history.at(START + number * 0.05 + 0.01)).toBe(number);
    }
    expect(history.at(START)).toBe(history.first - 1);
  });

  test("a class that appears later, or goes, leaves holes", () => {
    const history = filled(30, (i) =>
      i < 10 ? [row()] : i < 20 ? [row(), row({ class: "SLAM" })] : [row({ class: "SLAM" })],
    );
    expect(history.sample("SLAM", START + 0.2)).toBeNull();
    expect(history.sample("SLAM", START + 0.6)!.intensity).toBe(8);
    expect(history.sample("QR", START + 1.2)).toBeNull();
  });

  test("what a fast recording says holds until it says the next, however far on that is", () => {
    const history = new LaneHistory();
    for (const at of [0, 4, 8]) history.push({ stamp: START + at, rows: [row()] }, 10);
    expect(history.sample("QR", START + 3.9)!.intensity).toBe(8);
    const columns = new Columns(100);
    toColumns(history, history.lanes.get("QR")!.intensity, { from: START, to: START + 10, width: 100 }, columns);
    expect([0, 1].map((i) => columns.end[i]! - columns.x[i + 1]!)).toEqual([0, 0]);
  });

  test("of several inputs each one's φ is kept, once for as long as it stays", () => {
    const each = (scans: number) => ({ "QR.images": 1, "QR.scans": scans });
    const history = filled(4, (number) => [row({ divisors: each(number < 3 ? 2 : 4) })]);
    expect(history.sample("QR", START + 0.05)!.divisors).toEqual(each(2));
    expect(history.sample("QR", START + 0.15)!.divisors).toEqual(each(4));
    const { divisors } = history.lanes.get("QR")!;
    expect(divisors[1]).toBe(divisors[0]);
    expect(filled(1, () => [row({})]).sample("QR", START)!.divisors).toEqual({});
  });

  test("nothing is known in a silence, beyond the end, or of undesired values", () => {
    const history = filled(2, () => [row({ intensity: null, divisor: null })]);
    history.push({ stamp: START + 10, rows: [row()] });
    expect(history.sample("QR", START + 0.05)).toMatchObject({ intensity: null, divisor: null, rate: 0.5 });
    expect(history.sample("QR", START + 5)).toBeNull();
    expect(history.sample("QR", START + 10.5)!.intensity).toBe(8);
    expect(history.sample("QR", START + 12)).toBeNull();
  });

  test("late messages are dropped; a clock set back starts again", () => {
    const history = filled(100, () => [row()]);
    history.push({ stamp: START, rows: [row()] });
    expect(history.count).toBe(100);
    history.push({ stamp: START - 100, rows: [row()] });
    expect(history.count).toBe(1);
  });
});

describe("the past that the robot sends", () => {
  /** Twice a second from `from` on; QR was undesired until sample `at`, with a reason since. */
  function past(from: number, count: number, at: number): LanesHistory {
    const before = {
      intensity: null,
      utility: null,
      divisor: null,
      divisors: {},
      state: "undesired",
      text: "No desire",
    } as const;
    const since = {
      intensity: 8,
      utility: 2,
      divisor: 4,
      divisors: {},
      state: "degraded",
      text: "Too costly",
    } as const;
    return {
      stamps: Array.from({ length: count }, (_, i) => from + i * 0.5),
      rows: [
        {
          class: "QR",
          rate: Array.from({ length: count }, (_, i) => (i < at ? null : i / count)),
          spells: [
            { at: 0, ...before },
            { at, ...since },
          ],
        },
      ],
    };
  }

  test("fills an empty page, with reasons, as if it had been there", () => {
    const history = new LaneHistory();
    history.fill(past(START, 1200, 800));
    expect(history.count).toBe(1200);
    expect(history.sample("QR", START + 399.7)).toMatchObject({ intensity: null, state: "undesired", rate: null });
    const later = history.sample("QR", START + 400.1)!;
    expect(later).toMatchObject({
      intensity: 8,
      utility: 2,
      divisor: 4,
      divisors: {},
      state: "degraded",
      text: "Too costly",
    });
    expect(later.rate).toBeCloseTo(800 / 1200, 5);
    history.push({ stamp: START + 600, rows: [row()] });
    expect(history.sample("QR", START + 600.1)!.intensity).toBe(8);
    const seen: number[] = [];
    spells(history, history.lanes.get("QR")!, { from: START, to: START + 600 }, (_, a, b) => seen.push(a, b));
    expect(seen.map((stamp) => stamp - START)).toEqual([0, 400, 400, 600, 600, 600]);
  });

  test("after a break adds what was missed and leaves what was heard", () => {
    const history = filled(200, () => [row({ text: "heard" })]);
    history.fill(past(START - 300, 640, 100));
    expect(history.first).toBe(0);
    expect(history.oldest).toBe(START);
    expect(history.sample("QR", START + 9.96)!.text).toBe("heard");
    expect(history.sample("QR", START + 12)!.text).toBe("Too costly");
    expect(history.newest).toBe(START + 19.5);
    history.fill(past(START - 300, 640, 100));
    expect(history.newest).toBe(START + 19.5);
    expect(history.count).toBe(220);
  });

  test("a robot whose clock was set back has a new past; no past changes nothing", () => {
    const history = filled(200, () => [row({ text: "heard" })]);
    history.fill({ stamps: [], rows: [] });
    expect(history.count).toBe(200);
    history.fill(past(START - 5000, 50, 10));
    expect(history.count).toBe(50);
    expect(history.oldest).toBe(START - 5000);
  });
});

describe("columns", () => {
  test("never more than the width, whatever the history holds, and extremes survive", () => {
    const history = filled(CAPACITY, (i) => [row({ intensity: i === 6000 ? 8 : 2 })]);
    const columns = new Columns(300);
    toColumns(history, history.lanes.get("QR")!.intensity, { from: START, to: START + 600, width: 300 }, columns);
    expect(columns.length).toBeLessThanOrEqual(301);
    expect(columns.length).toBeGreaterThan(290);
    expect(Math.max(...columns.high.subarray(0, columns.length))).toBe(8);
    expect(Math.min(...columns.low.subarray(0, columns.length))).toBe(2);
  });

  test("sparse samples keep their places and hold until the next", () => {
    const history = filled(20, (i) => [row({ rate: i < 10 ? 1 : 0.5 })]);
    const columns = new Columns(1000);
    toColumns(history, history.lanes.get("QR")!.rate, { from: START, to: START + 1, width: 1000 }, columns);
    expect(columns.length).toBe(20);
    expect(columns.x[10]).toBeCloseTo(500, 1);
    expect(columns.end[9]).toBeCloseTo(500, 1);
    expect(columns.mean[10]).toBe(0.5);
  });

  test("what held at the left edge is drawn from it, and holes stay holes", () => {
    const history = filled(20, (i) => [row({ utility: i >= 5 && i < 10 ? null : 3 })]);
    const columns = new Columns(100);
    toColumns(history, history.lanes.get("QR")!.utility, { from: START + 0.12, to: START + 0.9, width: 78 }, columns);
    expect(columns.x[0]).toBe(0);
    const starts = [...columns.x.subarray(0, columns.length)];
    expect(starts.some((x) => x > 14 && x < 37)).toBe(false);
    expect(columns.end[2]).toBeLessThanOrEqual(14);
  });

  test("a silence ends the column before it", () => {
    const history = new LaneHistory();
    history.push({ stamp: START, rows: [row()] });
    history.push({ stamp: START + 20, rows: [row()] });
    const columns = new Columns(300);
    toColumns(history, history.lanes.get("QR")!.rate, { from: START - 5, to: START + 25, width: 300 }, columns);
    expect([...columns.x.subarray(0, columns.length)]).toEqual([50, 250]);
    expect(columns.end[0]).toBeCloseTo(60, 3);
  });
});

describe("spells", () => {
  function visited(history: LaneHistory, from: number, to: number) {
    const seen: [string, number, number][] = [];
    spells(history, history.lanes.get("QR")!, { from: START + from, to: START + to }, (state, a, b) =>
      seen.push([state, Number((a - START).toFixed(2)), Number((b - START).toFixed(2))]),
    );
    return seen;
  }

  test("each stretch of one state is one spell, cut at the right edge", () => {
    const history = filled(100, (i) => [row({ state: i < 40 ? "fulfilled" : "degraded" })]);
    expect(visited(history, 0, 4)).toEqual([
      ["fulfilled", 0, 2],
      ["degraded", 2, 4],
    ]);
    expect(visited(history, 2.5, 3)).toEqual([["degraded", 2.5, 3]]);
  });

  test("a silence ends a spell, even when the state is the same after it", () => {
    const history = filled(20, () => [row({ state: "degraded" })]);
    history.push({ stamp: START + 30, rows: [row({ state: "degraded" })] });
    expect(visited(history, 0, 30.5)).toEqual([
      ["degraded", 0, 1.95],
      ["degraded", 30, 30.5],
    ]);
    expect(visited(history, 10, 29)).toEqual([]);
  });

  test("nothing before the first sample", () => {
    expect(
      visited(
        filled(1, () => [row()]),
        -20,
        -10,
      ),
    ).toEqual([]);
  });
});

test("a tooltip is over its row, else under it, and never over the head of the lanes", () => {
  expect(placeBeside(300, 340, 150, 100, 500)).toBe(150);
  expect(placeBeside(120, 160, 150, 100, 500)).toBe(160);
  expect(placeBeside(200, 260, 150, 100, 400)).toBe(250);
  expect(placeBeside(120, 160, 150, 100, 200)).toBe(100);
});

describe("viewport", () => {
  const now = START + 1000;

  test("live follows the clock a little behind", () => {
    expect(edges(INITIAL, now)).toEqual({ from: now - TRAIL_S - 30, to: now - TRAIL_S });
  });

  test("zoom stays between its bounds, and keeps the time under the hand while paused", () => {
    expect(zoom(INITIAL, 1000).windowS).toBe(SHORTEST_S);
    expect(zoom(INITIAL, 0.001).windowS).toBe(LONGEST_S);
    const held = togglePause(INITIAL, now);
    const before = edges(held, now);
    const after = edges(zoom(held, 2, 0.25), now + 3);
    const at = (e: { from: number; to: number }) => e.from + (e.to - e.from) * 0.25;
    expect(at(after)).toBeCloseTo(at(before), 6);
  });

  test("panning back holds, panning to the present lets go, and the past has an end", () => {
    const back = pan(INITIAL, 10, now, START);
    expect(back.heldAt).toBeCloseTo(now - TRAIL_S - 10, 6);
    expect(pan(back, -11, now, START).heldAt).toBeNull();
    expect(pan(back, 1e6, now, START).heldAt).toBeCloseTo(START + 7.5, 6);
  });

  test("the buttons walk the usual windows", () => {
    expect(stepZoom(INITIAL, 1).windowS).toBe(60);
    expect(stepZoom(INITIAL, -1).windowS).toBe(20);
    expect(stepZoom({ windowS: 600, heldAt: null }, 1).windowS).toBe(1200);
    expect(stepZoom({ windowS: 3600, heldAt: null }, 1).windowS).toBe(3600);
    expect(stepZoom({ windowS: 10, heldAt: null }, -1).windowS).toBe(10);
  });
});

test("a tick has no label where it would run into the edge's", () => {
  const labels = (edge: string) => ticks(30, 230, edge).map(({ label }) => label);
  expect(labels("now")).toEqual(["now", "−10 s", "−20 s"]);
  expect(labels("maintenant")).toEqual(["maintenant", "", "−20 s"]);
});
