import { expect, test } from "vitest";
import { Framer, levelDb, Resampler, toFloat, toInt16 } from "./samples";

const sine = (length: number, hz: number, rate: number, from = 0) =>
  Float32Array.from({ length }, (_, i) => Math.sin((2 * Math.PI * hz * (from + i)) / rate));

test("floats and int16 are inverse, and too loud is clipped, not wrapped", () => {
  const samples = new Int16Array([0, 1, -1, 32767, -32768]);
  expect(toInt16(toFloat(samples))).toEqual(samples);
  expect([...toInt16(new Float32Array([1.5, -1.5]))]).toEqual([32767, -32768]);
});

test("levels", () => {
  expect(levelDb(new Int16Array(100))).toBe(-100);
  expect(levelDb(new Int16Array(0))).toBe(-100);
  expect(levelDb(toInt16(sine(4800, 1000, 48_000)))).toBeCloseTo(-3.01, 1);
});

test("the same rate gives the same samples, two later", () => {
  const resampler = new Resampler();
  const heard = sine(960, 440, 48_000);
  const out = resampler.push(heard, 1);
  expect(out.length).toBe(960);
  expect(out[500]).toBeCloseTo(heard[498]!, 6);
});

test.each([0.995, 1, 1.01, 44_100 / 48_000])(
  "a step of %d, in pieces, is a sine of that pitch without seams",
  (step) => {
    const resampler = new Resampler();
    const out: number[] = [];
    for (let i = 0; i < 50; i++) out.push(...resampler.push(sine(512, 700, 48_000, 512 * i), step));
    expect(Math.abs(out.length - (50 * 512) / step)).toBeLessThan(3);
    out.slice(10).forEach((sample, i) => {
      const at = (i + 10) * step - 2;
      expect(Math.abs(sample - Math.sin((2 * Math.PI * 700 * at) / 48_000))).toBeLessThan(2e-3);
    });
  },
);

test("frames of equal length out of pieces of any", () => {
  const framer = new Framer(960);
  const all = sine(5000, 100, 48_000);
  const frames: Float32Array[] = [];
  for (let from = 0; from < 5000; from += 128) frames.push(...framer.push(all.slice(from, from + 128)));
  expect(frames.map(({ length }) => length)).toEqual([960, 960, 960, 960, 960]);
  expect(frames[3]).toEqual(all.slice(2880, 3840));
});
