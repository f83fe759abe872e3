import { expect, test } from "vitest";
import { drawnBox, palette, recolor } from "./colors";

const light = (colors: Uint8ClampedArray, value: number) => colors[4 * value + 1]!;

test("on the map walls are lighter than floor, and what is unknown shows the ground", () => {
  const map = palette("map_info");
  expect(light(map, 100)).toBeGreaterThan(light(map, 50));
  expect(light(map, 50)).toBeGreaterThan(light(map, 0));
  expect(map[4 * 0 + 3]).toBe(255);
  expect(map[4 * 255 + 3]).toBe(0);
});

test("of the costmap only what costs something is shown, the costlier the denser", () => {
  const costs = palette("costmap_info");
  expect(costs[3]).toBe(0);
  expect(costs[4 * 255 + 3]).toBe(0);
  expect(costs[4 * 100 + 3]!).toBeGreaterThan(costs[4 * 10 + 3]!);
});

test("every pixel gets its value's colour", () => {
  const colors = palette("map_info");
  const pixels = new Uint8ClampedArray([0, 0, 0, 255, 100, 100, 100, 255, 255, 255, 255, 255]);
  recolor(pixels, colors);
  expect([...pixels]).toEqual([...colors.slice(0, 4), ...colors.slice(400, 404), ...colors.slice(1020, 1024)]);
});

test("what is known of a map is found, and that nothing is", () => {
  const pixels = new Uint8ClampedArray(4 * 5 * 4);
  expect(drawnBox(pixels, 5)).toBeNull();
  for (const [column, row] of [
    [1, 2],
    [3, 1],
  ] as const)
    pixels[4 * (row * 5 + column) + 3] = 255;
  expect(drawnBox(pixels, 5)).toEqual({ left: 1, top: 1, right: 4, bottom: 3 });
});
