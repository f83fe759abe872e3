import { expect, test } from "vitest";
import { type PadSnapshot, readPads } from "./gamepad";
import { STANDARD, shape } from "./padMapping";

function pad(over: Partial<PadSnapshot> & { held?: number; pressed?: number[] } = {}): PadSnapshot {
  const pressed = new Set(over.pressed ?? []);
  return {
    id: "Pad A",
    index: 0,
    connected: true,
    axes: [0, 0, 0, 0],
    buttons: Array.from({ length: 16 }, (_, i) => ({ pressed: pressed.has(i) })),
    ...over,
  };
}

test("a pad drives only with a shoulder held", () => {
  const none = { chosen: null, axes: null, override: false, stop: false, home: false };
  expect(readPads([pad({ axes: [0, -1, 0, 0] })], null)).toEqual(none);
  const reading = readPads([null, pad({ axes: [0, -1, 0, 0], pressed: [5] })], null);
  expect(reading.chosen).toEqual({ id: "Pad A", index: 0 });
  expect(reading.axes).toEqual({ linear: 1, angular: 0, lateral: 0 });
});

test("a headset that calls itself a gamepad is ignored", () => {
  expect(readPads([pad({ axes: [], pressed: [4] })], null).axes).toBeNull();
});

test("the pad in use is kept, whatever another does, until it is gone", () => {
  const mine = pad({ id: "Pad B", index: 1, axes: [-1, 0, 0, 0], pressed: [4] });
  const other = pad({ axes: [0, -1, 0, 0], pressed: [4] });
  const chosen = { id: "Pad B", index: 1 };
  expect(readPads([other, mine], chosen).axes).toEqual({ linear: 0, angular: 1, lateral: 0 });
  expect(readPads([other], chosen)).toMatchObject({ chosen: null, axes: null, stop: false });
});

test("either stick turns, the further one wins", () => {
  expect(readPads([pad({ axes: [0.2, 0, -1, 0], pressed: [4] })], null).axes!.angular).toBe(1);
});

test("the left stick strafes a body that can, and the right one turns it", () => {
  const both = pad({ axes: [-1, 0, 1, 0], pressed: [4] });
  expect(readPads([both], null, true).axes).toEqual({ linear: 0, angular: -1, lateral: 1 });
  expect(readPads([pad({ axes: [-1, 0, 0, 0], pressed: [4] })], null, true).axes!.angular).toBe(0);
  expect(readPads([both], null).axes!.lateral).toBe(0);
});

test("the buttons to stop and to return count on any pad, held or not", () => {
  expect(readPads([pad({ pressed: [1] })], null)).toMatchObject({ stop: true, home: false });
  expect(readPads([pad({ pressed: [3] })], null)).toMatchObject({ stop: false, home: true });
});

test("a trigger of the pad in use overrides, no other pad's", () => {
  const mine = pad({ pressed: [4, 7] });
  expect(readPads([mine], null).override).toBe(true);
  const idle = pad({ id: "Pad B", index: 1, pressed: [6] });
  expect(readPads([pad({ pressed: [4] }), idle], null).override).toBe(false);
  expect(readPads([idle], null).override).toBe(false);
});

test("the curve is still in the deadband, odd, rising and full at the edge", () => {
  expect(shape(0.12)).toBe(0);
  expect(shape(NaN)).toBe(0);
  expect(shape(1)).toBeCloseTo(1);
  expect(shape(-1)).toBeCloseTo(-1);
  for (let v = 0.13; v < 1; v += 0.01) {
    expect(shape(v + 0.01)).toBeGreaterThan(shape(v));
    expect(shape(-v)).toBeCloseTo(-shape(v));
  }
});

test("another mapping moves sticks and buttons, inverts them, and is its pad's alone", () => {
  const mapping = { ...STANDARD, forward: 3, turn: [0], inverted: [3], deadMan: [2], stop: 9, deadband: 0, expo: 0 };
  const mappingOf = (id: string) => (id === "Pad A" ? mapping : STANDARD);
  const read = (over: Parameters<typeof pad>[0]) => readPads([pad(over)], null, false, mappingOf);
  expect(read({ axes: [0.5, -1, 1, 0.25], pressed: [2] }).axes).toEqual({ linear: 0.25, angular: -0.5, lateral: 0 });
  expect(read({ axes: [0, -1, 0, 0], pressed: [4] }).axes).toBeNull();
  expect(read({ pressed: [9] }).stop).toBe(true);
  expect(read({ pressed: [1] }).stop).toBe(false);
  expect(readPads([pad({ id: "Pad B", pressed: [1] })], null, false, mappingOf).stop).toBe(true);
});
