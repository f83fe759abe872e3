import { describe, expect, test } from "vitest";
import type { SaliencyMap, SalientRegion, SalientRegions } from "../protocol/types";
import { featureWords, fresh, heat, heatBox, markAt, regionMarks, saliencySummary } from "./saliencyMarks";
import { place } from "./stripProjection";

const region = (some: Partial<SalientRegion>): SalientRegion => ({
  azimuth: 0,
  elevation: 0,
  saliency: 1,
  motion: 0,
  color: 0,
  contrast: 0,
  faces: 0,
  sounds: 0,
  ...some,
});
const regions = (...found: SalientRegion[]): SalientRegions => ({ stamp: 10, p_BH: [0, 0, 1.3], regions: found });
const map = (cells: number[][], step = 0.1): SaliencyMap => ({ stamp: 10, step, full: 1, cells });
const strip = { width: 600, height: 200 };
const left = region({ azimuth: Math.PI / 6, motion: 0.7, sounds: 0.25, color: 0.05 });

describe("words", () => {
  test("features that gave enough, the most important first", () => {
    expect(featureWords(left)).toBe("motion and sound");
    expect(featureWords(region({ color: 0.3, faces: 0.4, motion: 0.3 }))).toBe("a face, motion and colour");
    expect(featureWords(region({ contrast: 1 }))).toBe("contrast");
  });

  test("marks are numbered by rank", () => {
    const marks = regionMarks(regions(left, region({ azimuth: -2, contrast: 1 })), 10.2);
    expect(marks.map(({ rank, text }) => [rank, text])).toEqual([
      [1, "1: motion and sound, 30° left"],
      [2, "2: contrast, 115° right"],
    ]);
  });

  test("the strip's summary names the first", () => {
    expect(saliencySummary(regions(left, region({ motion: 1 })), 10.2)).toBe(
      "most salient 30° left (motion and sound)",
    );
    expect(saliencySummary(regions(), 10.2)).toBe("");
  });
});

test("what nobody desires any more is not shown", () => {
  expect(fresh(map([[0]]), 11)).toBe(true);
  expect(fresh(map([[0]]), 12)).toBe(false);
  expect(fresh(null, 10)).toBe(false);
  expect(regionMarks(regions(left), 12)).toEqual([]);
  expect(regionMarks(null, 10)).toEqual([]);
  expect(saliencySummary(regions(left), 12)).toBe("");
});

test("a pointer is over the nearest ring within reach, also across the strip's ends", () => {
  const behind = region({ azimuth: Math.PI - 0.01 });
  const marks = regionMarks(regions(left, behind), 10);
  const { x, y } = place(strip, left.azimuth, left.elevation);
  expect(markAt(marks, strip, { x: x + 6, y: y - 6 }, 12)?.rank).toBe(1);
  expect(markAt(marks, strip, { x: x + 30, y }, 12)).toBeNull();
  expect(markAt(marks, strip, { x: 598, y: 100 }, 12)?.rank).toBe(2);
  expect(markAt([], strip, { x, y }, 12)).toBeNull();
});

test("the more salient a cell, the less transparent; what hardly is cannot be seen", () => {
  const { width, height, pixels } = heat(
    map([
      [0, 5, 60],
      [120, 200, 255],
    ]),
  );
  expect([width, height]).toEqual([3, 2]);
  const opacities = Array.from({ length: 6 }, (_, i) => pixels[4 * i + 3]!);
  expect(opacities.slice(0, 2)).toEqual([0, 0]);
  expect(opacities).toEqual([...opacities].sort((a, b) => a - b));
  expect(opacities[5]).toBeLessThan(160);
});

test("cells lie under their own directions", () => {
  const rows = 10;
  const step = (2 * Math.PI) / 60;
  const cells = Array.from({ length: rows }, () => new Array<number>(60).fill(0));
  const box = heatBox(strip, map(cells, step));
  const [row, column] = [3, 20];
  const { x, y } = place(strip, Math.PI - (column + 0.5) * step, (rows / 2 - row - 0.5) * step);
  expect(x).toBeCloseTo(box.x + ((column + 0.5) * box.width) / 60);
  expect(y).toBeCloseTo(box.y + ((row + 0.5) * box.height) / rows);
});
