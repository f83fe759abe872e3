import { expect, test } from "vitest";
import { HEARD, packVoice, parseSound, SPOKEN } from "./sound";

test("a spoken frame has the header that docs/live-stream.md says", () => {
  const frame = packVoice({ seq: 7, stamp: 1234.5, rate: 48_000, samples: new Int16Array([1, -2, 32767]) });
  const view = new DataView(frame);
  expect(frame.byteLength).toBe(30);
  expect([view.getUint8(0), view.getUint8(1), view.getUint32(4, true)]).toEqual([SPOKEN, 0, 7]);
  expect(view.getFloat64(8, true)).toBe(1234.5);
  expect([view.getUint16(16, true), view.getUint16(18, true), view.getUint32(20, true)]).toEqual([3, 1, 48_000]);
  expect([0, 1, 2].map((i) => view.getInt16(24 + 2 * i, true))).toEqual([1, -2, 32767]);
});

test("the end of a talk is a header alone", () => {
  expect(packVoice({ seq: 1, stamp: 0, rate: 48_000, samples: new Int16Array(0) }).byteLength).toBe(24);
});

test("a heard frame is read back", () => {
  const frame = packVoice({ seq: 9, stamp: 2.25, rate: 16_000, samples: new Int16Array([5, 6]) });
  new DataView(frame).setUint8(0, HEARD);
  expect(parseSound(frame)).toEqual({ seq: 9, stamp: 2.25, rate: 16_000, samples: new Int16Array([5, 6]) });
});

test("what is no sound, or cut short, is passed over", () => {
  const frame = packVoice({ seq: 9, stamp: 0, rate: 48_000, samples: new Int16Array(10) });
  expect(parseSound(frame)).toBeNull();
  new DataView(frame).setUint8(0, HEARD);
  expect(parseSound(frame.slice(0, 40))).toBeNull();
  expect(parseSound(frame.slice(0, 8))).toBeNull();
});
