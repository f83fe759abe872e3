import { describe, expect, test } from "vitest";
import { direction, pictureBox, place, SHAPE, wrapped } from "./stripProjection";

const strip = { width: 720, height: 720 / SHAPE };

test("ahead is in the middle, left on the left, behind at the ends", () => {
  expect(place(strip, 0, 0)).toEqual({ x: 360, y: 120 });
  expect(place(strip, Math.PI / 2, 0).x).toBeCloseTo(180);
  expect(place(strip, -Math.PI / 2, 0).x).toBeCloseTo(540);
  expect(place(strip, Math.PI - 1e-9, 0).x).toBeCloseTo(0);
  expect(place(strip, -Math.PI + 1e-9, 0).x).toBeCloseTo(720);
});

test("a degree is as long across as along, and up is up", () => {
  expect(place(strip, 0, Math.PI / 6).y).toBeCloseTo(60);
  expect(place(strip, Math.PI / 6, 0).x).toBeCloseTo(300);
});

test("what is higher than the strip reaches is at its edge", () => {
  expect(place(strip, 0, Math.PI / 2).y).toBe(0);
  expect(place(strip, 0, -Math.PI / 2).y).toBe(240);
});

test("a turn more or less is the same direction", () => {
  expect(place(strip, 0.3 + 2 * Math.PI, 0).x).toBeCloseTo(place(strip, 0.3, 0).x);
  expect(wrapped(1.5 * Math.PI)).toBeCloseTo(-Math.PI / 2);
});

describe("there and back", () => {
  for (const azimuth of [-3.1, -1, 0, 0.4, 3.1])
    for (const elevation of [-1, 0, 0.7])
      test(`${azimuth} ${elevation}`, () => {
        const back = direction(strip, place(strip, azimuth, elevation));
        expect(back.azimuth).toBeCloseTo(azimuth);
        expect(back.elevation).toBeCloseTo(elevation);
      });
});

test("the panorama lies under its own directions: docs/live-stream.md's formula and the strip's agree", () => {
  const [w, h] = [640, 384];
  const box = pictureBox(strip, w, h);
  expect(box).toEqual({ x: 180, y: 12, width: 360, height: 216 });
  for (const [azimuth, elevation] of [
    [0.5, 0.2],
    [-1.2, -0.6],
  ] as const) {
    const { x, y } = place(strip, azimuth, elevation);
    const [px, py] = [w * (0.5 - azimuth / Math.PI), h / 2 - (w * elevation) / Math.PI];
    expect(x).toBeCloseTo(box.x + (px * box.width) / w);
    expect(y).toBeCloseTo(box.y + (py * box.height) / h);
  }
});
