import { expect, test } from "vitest";
import { checked, keepMapping, mappingOf, movedAxis, pressedButton, STANDARD, shape } from "./padMapping";

function shelf(text: string | null = null) {
  const kept = new Map<string, string>(text === null ? [] : [["hbba.pad.A", text]]);
  return {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
  };
}

test("a mapping is kept for its kind of pad alone", () => {
  const storage = shelf();
  const mine = { ...STANDARD, stop: 9, expo: 0.2, inverted: [1] };
  keepMapping("A", mine, storage);
  expect(mappingOf("A", storage)).toEqual(mine);
  expect(mappingOf("B", storage)).toBe(STANDARD);
});

test.each([
  "{",
  "3",
  "null",
  "{}",
  JSON.stringify({ ...STANDARD, deadMan: [] }),
  JSON.stringify({ ...STANDARD, expo: 4 }),
])("a damaged mapping, %s, is the standard one", (text) => {
  expect(mappingOf("A", shelf(text))).toBe(STANDARD);
});

test("the dead-man does nothing else", () => {
  expect(checked({ ...STANDARD, stop: 4 })).toBeNull();
  expect(checked({ ...STANDARD, override: [5] })).toBeNull();
});

test("the curve is odd, starts at the deadband and ends at one", () => {
  for (const expo of [0, 0.6, 1]) {
    const curve = { deadband: 0.2, expo };
    expect(shape(0.2, curve)).toBe(0);
    expect(shape(1, curve)).toBeCloseTo(1);
    expect(shape(-0.7, curve)).toBeCloseTo(-shape(0.7, curve));
    expect(shape(0.7, curve)).toBeGreaterThan(shape(0.5, curve));
  }
});

test("what was moved or pressed is found, drift is not", () => {
  expect(movedAxis([0, 0, -1], [0.1, 0.9, -1])).toBe(1);
  expect(movedAxis([0, 0], [0.2, 0.3])).toBeNull();
  expect(pressedButton([true, false], [true, true])).toBe(1);
  expect(pressedButton([true, false], [true, false])).toBeNull();
});
