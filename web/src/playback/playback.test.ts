import { expect, test, vi } from "vitest";
import { actionOf, isDated, slowerThanAsked, spokenSpan, target } from "./transport";
import { Turns } from "./turns";

const key = (code: string, where: Partial<{ typing: boolean; ownsArrows: boolean; pressable: boolean }> = {}) =>
  actionOf({ code, typing: false, ownsArrows: false, pressable: false, ...where });

test("keys of a recording", () => {
  const codes = ["Space", "Period", "Comma", "ArrowRight", "ArrowLeft", "Home", "End", "KeyW"];
  expect(codes.map((code) => key(code))).toEqual(["toggle", "step", "back", "skip", "rewind", "begin", "end", null]);
});

test("typing, and what has its own use for a key, keep it", () => {
  expect(key("Space", { typing: true })).toBeNull();
  expect(key("Home", { typing: true })).toBeNull();
  expect(key("Space", { pressable: true })).toBeNull();
  expect(key("ArrowLeft", { ownsArrows: true })).toBeNull();
  expect(key("Period", { ownsArrows: true, pressable: true })).toBe("step");
});

test("where keys lead, within the recording", () => {
  const log = { begin: 100, end: 160 };
  expect(target("skip", 120, log)).toBe(125);
  expect(target("skip", 158, log)).toBe(160);
  expect(target("rewind", 102, log)).toBe(100);
  expect(target("back", 130, log)).toBeCloseTo(129.9);
  expect([target("begin", 130, log), target("end", 130, log)]).toEqual([100, 160]);
  expect([target("toggle", 130, log), target("step", 130, log)]).toEqual([null, null]);
});

test("times along a recording, in words", () => {
  expect([0, 1, 62, 3600].map(spokenSpan)).toEqual(["the beginning", "1 second", "1 minute 2 seconds", "1 hour"]);
  expect([1_790_000_000, 12.5].map(isDated)).toEqual([true, false]);
});

test("a computer too slow for the speed asked is said to be", () => {
  expect(slowerThanAsked({ speed: 8, playing: true }, 3)).toBe(true);
  expect(slowerThanAsked({ speed: 8, playing: true }, 7.9)).toBe(false);
  expect(slowerThanAsked({ speed: null, playing: true }, 3)).toBe(false);
  expect(slowerThanAsked({ speed: 8, playing: false }, 0)).toBe(false);
});

test("of a drag one request is under way at a time, and the newest wins", async () => {
  const sent: number[] = [];
  let answer: () => void = () => undefined;
  const turns = new Turns(
    (position) => {
      sent.push(position);
      return new Promise((resolve) => (answer = resolve));
    },
    () => undefined,
    () => undefined,
  );
  for (const position of [1, 2, 3, 4]) turns.seek(position);
  expect(sent).toEqual([1]);
  expect(turns.wanted).toBe(4);
  answer();
  await new Promise((resolve) => setTimeout(resolve));
  expect(sent).toEqual([1, 4]);
  expect(turns.wanted).toBe(4);
  answer();
  await new Promise((resolve) => setTimeout(resolve));
  expect(turns.wanted).toBeNull();
});

test("a refused seek gives the position back, and only the last refusal is reported", async () => {
  const failures: unknown[] = [];
  const turns = new Turns(
    (position) => Promise.reject(new Error(`not ${position}`)),
    () => undefined,
    (error) => failures.push(error),
  );
  turns.seek(1);
  turns.seek(2);
  await new Promise((resolve) => setTimeout(resolve));
  expect(failures.map(String)).toEqual(["Error: not 2"]);
  expect(turns.wanted).toBeNull();
});

test("everything has its turn in the order of the hand, and only seeks in a row become one", async () => {
  const done: string[] = [];
  const takes = (what: string) => async () => {
    await new Promise((resolve) => setTimeout(resolve));
    done.push(what);
  };
  const turns = new Turns(
    (position) => takes(`seek ${position}`)(),
    () => undefined,
    (error) => done.push(String(error)),
  );
  turns.seek(1);
  turns.ask(takes("pause"));
  turns.ask(() => Promise.reject(new Error("no such speed")));
  turns.seek(2);
  turns.seek(3);
  turns.ask(takes("step"));
  await vi.waitFor(() => expect(done).toHaveLength(5));
  expect(done).toEqual(["seek 1", "pause", "Error: no such speed", "seek 3", "step"]);
  expect(turns.wanted).toBeNull();
});
