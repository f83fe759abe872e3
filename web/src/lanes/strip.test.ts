import { expect, test } from "vitest";
import { Strip } from "./strip";

const START = 1_790_000_000;

/** 300 columns of 10 a second are seen, 450 are kept. */
function strip(): Strip {
  const made = new Strip();
  made.resize(300);
  return made;
}
const at = (to: number) => ({ from: START + to - 30, to: START + to });

test("what is drawn once is not drawn again: a tick draws the new columns alone", () => {
  const made = strip();
  expect(made.cover(at(0), START + 0.44)).toEqual({ from: 0, to: 304, whole: true });
  expect(made.cover(at(0.25), START + 0.69)).toEqual({ from: 304, to: 306, whole: false });
  expect(made.cover(at(0.3), START + 0.69)).toBeNull();
  expect(made.column(START)).toBeCloseTo(300, 4);
  expect(made.stamp(300)).toBeCloseTo(START, 4);
});

test("where the strip ends, it begins again at the view, by whole columns", () => {
  const made = strip();
  made.cover(at(0), START);
  expect(made.room(at(0))).toBe(150);
  expect(made.cover(at(14.65), START + 15)).toEqual({ from: 300, to: 450, whole: false });
  // Before the next tick it would have come to the end.
  expect(made.cover(at(14.85), START + 14.86)).toEqual({ from: 0, to: 300, whole: true });
  expect(made.column(START - 15.2)).toBeCloseTo(0, 4);
});

test("another zoom, another width and a view before the strip draw it all", () => {
  const made = strip();
  made.cover(at(0), START);
  expect(made.cover({ from: START - 60, to: START }, START)).toMatchObject({ whole: true, from: 0, to: 300 });
  expect(made.cover({ from: START - 90, to: START - 30 }, START)).toMatchObject({ whole: true, from: 0, to: 450 });
  made.resize(200);
  expect(made.cover(at(0), START)).toEqual({ from: 0, to: 200, whole: true });
});

test("what came late for its time is drawn again from there on, as often as it comes", () => {
  const made = strip();
  made.cover(at(0), START);
  made.invalidate(START - 2);
  made.invalidate(START - 1);
  expect(made.cover(at(0), START)).toEqual({ from: 280, to: 300, whole: false });
  made.invalidate(START - 500);
  expect(made.cover(at(0), START)).toEqual({ from: 0, to: 300, whole: false });
});

test("nothing known of the time that is seen: the strip is emptied once", () => {
  const made = strip();
  expect(made.cover(at(0), START - 100)).toEqual({ from: 0, to: 0, whole: true });
  expect(made.cover(at(0.25), START - 100)).toBeNull();
});
