import { expect, test } from "vitest";
import type { Sound } from "../protocol/sound";
import { Playout } from "./playout";

const RATE = 48_000;
const FRAME = 960;
const frame = (seq: number, stamp = seq * 0.02): Sound => ({
  seq,
  stamp,
  rate: RATE,
  samples: Int16Array.from(
    { length: FRAME },
    (_, i) => 8000 * Math.sin((2 * Math.PI * 300 * (seq * FRAME + i)) / RATE),
  ),
});

const SILENCE = new Int16Array(FRAME);

/** Silent frames of 20 ms, each `delay(seq)` s late; the robot's clock runs `faster` than the computer's. */
function run(frames: number, delay: (seq: number) => number, faster = 0) {
  const playout = new Playout(RATE);
  const arrivals = Array.from({ length: frames }, (_, seq) => ({
    seq,
    at: (seq * 0.02) / (1 + faster) + delay(seq),
  })).sort((a, b) => a.at - b.at || a.seq - b.seq);
  const pieces = arrivals.map(({ seq, at }) => ({
    seq,
    now: at,
    piece: playout.push({ seq, stamp: 0.02 * seq, rate: RATE, samples: SILENCE }, at),
  }));
  return { playout, pieces };
}

const gaps = (pieces: ReturnType<typeof run>["pieces"]) => {
  const played = pieces.flatMap(({ piece }) => piece ?? []);
  return played.slice(1).filter((piece, i) => {
    const before = played[i]!;
    return Math.abs(before.at + before.samples.length / RATE - piece.at) > 1e-9;
  }).length;
};

test("nothing is played in the past, nor two pieces at once", () => {
  const { pieces } = run(500, (seq) => (seq % 50 === 0 ? 0.25 : 0.01 * (seq % 3)));
  let end = 0;
  for (const { now, piece } of pieces) {
    if (!piece) continue;
    expect(piece.at).toBeGreaterThan(now);
    expect(piece.at).toBeGreaterThanOrEqual(end - 1e-9);
    end = piece.at + piece.samples.length / RATE;
  }
});

test("an even network gives sound without a gap, 0.1 s late, then less", () => {
  const { playout, pieces } = run(1500, () => 0.03);
  expect(gaps(pieces)).toBe(0);
  expect(pieces.every(({ piece }) => piece)).toBe(true);
  const { now, piece } = pieces.at(-1)!;
  expect(pieces[0]!.piece!.at - pieces[0]!.now).toBeCloseTo(0.1, 3);
  expect(piece!.at - now).toBeLessThan(0.1);
  expect(playout.aim).toBeLessThan(0.085);
});

test.each([0.002, -0.002])("a clock that is off by %d is followed for a minute without a gap", (faster) => {
  const { playout, pieces } = run(3000, (seq) => 0.02 + 0.004 * (seq % 4), faster);
  expect(gaps(pieces)).toBe(0);
  const { now, piece } = pieces.at(-1)!;
  expect(Math.abs(piece!.at - now - playout.aim)).toBeLessThan(0.05);
});

test("after a hitch what is too late is left out, and the delay does not stay", () => {
  // For half a second nothing comes, then everything at once.
  const { pieces } = run(300, (seq) => (seq >= 100 && seq < 125 ? (125 - seq) * 0.02 : 0));
  expect(pieces.some(({ piece }) => piece === null)).toBe(true);
  const { now, piece } = pieces.at(-1)!;
  expect(piece!.at - now).toBeLessThan(0.28);
});

test("a hitch makes the reserve larger", () => {
  const { playout } = run(60, (seq) => (seq >= 30 ? 0.4 : 0));
  expect(playout.aim).toBeGreaterThan(0.13);
});

test("what is heard has the robot's time; silence has none", () => {
  const playout = new Playout(RATE);
  const first = playout.push(frame(0, 50), 1)!;
  playout.push(frame(1, 50.02), 1.02);
  expect(playout.heard(first.at + 0.03)!.stamp).toBeCloseTo(50.03, 4);
  expect(playout.heard(first.at + 0.03)!.level).toBeCloseTo(20 * Math.log10(8000 / 32768) - 3.01, 0);
  expect(playout.heard(first.at - 0.01)).toBeNull();
  expect(playout.heard(first.at + 1)).toBeNull();
});

test("seams are smooth: at the beginning, and where a frame was lost", () => {
  const playout = new Playout(RATE);
  const pieces = [0, 1, 2, 5, 6].map((seq, i) => playout.push(frame(seq), 0.02 * i)!);
  const whole = pieces.flatMap(({ samples }) => [...samples]);
  const steps = whole.slice(1).map((sample, i) => Math.abs(sample - whole[i]!));
  expect(Math.abs(whole[0]!)).toBeLessThan(0.01);
  expect(Math.max(...steps)).toBeLessThan(0.03);
});

test("another rate than the loudspeaker's is brought to it", () => {
  const playout = new Playout(44_100);
  const lengths = [0, 1, 2, 3, 4].map((seq) => playout.push(frame(seq), 0.02 * seq)!.samples.length);
  expect(lengths.reduce((sum, length) => sum + length)).toBeGreaterThan(5 * 882 - 5);
  expect(lengths.reduce((sum, length) => sum + length)).toBeLessThan(5 * 882 + 5);
});
