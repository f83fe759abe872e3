import { expect, test } from "vitest";
import { PlaybackClock } from "./playbackClock";

const BEGIN = 1_790_000_000;
const report = (position: number, speed: number | null = 1, playing = true) => ({
  position: BEGIN + position,
  end: BEGIN + 60,
  speed,
  playing,
});

test("unknown before the first report", () => {
  expect(new PlaybackClock().now(5)).toBeNull();
});

test("a paused recording stands still, exactly at the reported position", () => {
  const clock = new PlaybackClock();
  clock.report(report(12.25, 1, false), 3);
  expect([3, 4, 500].map((at) => clock.now(at)! - BEGIN)).toEqual([12.25, 12.25, 12.25]);
});

test.each([0.25, 1, 8])("at speed %d it runs on between the reports, smoothly and never backwards", (speed) => {
  const clock = new PlaybackClock();
  const late = [0.01, 0.03, 0.0, 0.02, 0.04];
  let before = -Infinity;
  for (let i = 0; i < 300; i++) {
    const at = i / 60;
    if (i % 6 === 0) clock.report(report(speed * (at - late[(i / 6) % 5]!), speed), at);
    const now = clock.now(at)! - BEGIN;
    expect(now).toBeGreaterThanOrEqual(before);
    if (i > 60) expect(Math.abs(now - speed * at)).toBeLessThan(speed * 0.06);
    before = now;
  }
});

test("as fast as possible, and slower than asked, run at the pace they have", () => {
  for (const speed of [null, 8]) {
    const clock = new PlaybackClock();
    for (let i = 0; i <= 30; i++) clock.report(report(i * 0.3, speed), i / 10);
    expect(clock.rate).toBeCloseTo(3, 3);
    expect(clock.now(3.05)! - BEGIN).toBeCloseTo(9.15, 1);
  }
});

test("a jump is followed at once, forwards and backwards", () => {
  const clock = new PlaybackClock();
  clock.report(report(10), 0);
  clock.report(report(40), 0.1);
  expect(clock.now(0.1)! - BEGIN).toBeCloseTo(40, 6);
  clock.report(report(2), 0.2);
  expect(clock.now(0.2)! - BEGIN).toBeCloseTo(2, 6);
  expect(clock.now(0.3)! - BEGIN).toBeCloseTo(2.1, 3);
});

test("a new speed holds from its first report on", () => {
  const clock = new PlaybackClock();
  for (let i = 0; i <= 10; i++) clock.report(report(i / 10), i / 10);
  clock.report(report(1.1, 4), 1.1);
  expect(clock.rate).toBe(4);
  expect(clock.now(1.2)! - BEGIN).toBeCloseTo(1.5, 2);
});

test("it does not run past the end", () => {
  const clock = new PlaybackClock();
  clock.report(report(59.95, 8), 0);
  expect(clock.now(5)! - BEGIN).toBe(60);
});
