import { expect, test } from "vitest";
import { RobotClock } from "./robotClock";

const TRUE_OFFSET = 1_790_000_000;

test("unknown before anything was heard", () => {
  expect(new RobotClock().now(5)).toBeNull();
});

test("the least delayed message and half the shortest trip give the clock", () => {
  const clock = new RobotClock();
  const delays = [0.08, 0.03, 0.02, 0.3, 0.05];
  delays.forEach((delay, i) => clock.heard(TRUE_OFFSET + i, i + delay));
  clock.roundTrip(0.1, 4);
  clock.roundTrip(0.04, 4.5);
  expect(clock.now(5)! - (TRUE_OFFSET + 5)).toBeCloseTo(0, 6);
});

test("a late burst does not pull the clock back at once, and corrections never run time backwards", () => {
  const clock = new RobotClock();
  clock.heard(TRUE_OFFSET, 0);
  let before = clock.now(0)!;
  for (let i = 1; i < 1500; i++) {
    const at = i * 0.016;
    if (i % 3 === 0) clock.heard(TRUE_OFFSET + at - 0.2, at); // the link grew 200 ms slower
    const now = clock.now(at)!;
    expect(now).toBeGreaterThan(before);
    expect(now - before).toBeLessThan(0.017);
    before = now;
  }
});

test("a clock that was set is followed at once", () => {
  const clock = new RobotClock();
  clock.heard(TRUE_OFFSET, 0);
  clock.now(0);
  clock.heard(TRUE_OFFSET + 60, 1);
  expect(clock.now(1)).toBeCloseTo(TRUE_OFFSET + 60, 3);
});
