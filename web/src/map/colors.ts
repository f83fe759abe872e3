/**
 * The map's colours, distinguished by lightness and shape as well: Okabe and Ito's (jfly.uni-koeln.de/color), lightened for a
 * dark ground. Pure.
 */

import type { GridInfo } from "../protocol/types";

export const UNKNOWN = "#0b0f15";
export const PATH = "#56b4e9";
export const GOAL = "#f0e442";
export const ROBOT = "#ffffff";
/** Where the robot will be when a command given now arrives. */
export const AHEAD = "#ffd34d";
export const WITHIN_LIMIT = "rgb(255 211 77 / 0.12)";
export const PAST_LIMIT = "rgb(255 211 77 / 0.38)";
export const ROBOT_EDGE = "#1f4f9e";
export const UNSURE = "rgb(150 200 255 / 0.28)";
export const KEEP_OUT = "#ff8a4c";
export const SLOW = "#f0e442";
export const PERSON = "rgb(70 225 140)";
export const POSTER = "rgb(250 204 80)";
export const PLACE = "#8fd3ff";

type Rgba = readonly [number, number, number, number];
const FREE: Rgba = [46, 57, 73, 255];
const OCCUPIED: Rgba = [236, 241, 248, 255];
const NOTHING: Rgba = [0, 0, 0, 0];
/** Reddish purple: neither the map's white nor any zone's colour. */
const COST = [214, 128, 182] as const;
const UNKNOWN_CELL = 255;

/** What each grey value of a picture is drawn as, 256 × RGBA. */
export function palette(kind: GridInfo["type"]): Uint8ClampedArray {
  const colors = new Uint8ClampedArray(4 * 256);
  for (let value = 0; value < 256; value++)
    colors.set(kind === "map_info" ? mapColor(value) : costColor(value), 4 * value);
  return colors;
}

/** In place: RGBA of a grey picture to its colours. */
export function recolor(pixels: Uint8ClampedArray, colors: Uint8ClampedArray): void {
  const from = new Uint32Array(colors.buffer);
  const to = new Uint32Array(pixels.buffer, pixels.byteOffset, pixels.byteLength / 4);
  for (let i = 0; i < to.length; i++) to[i] = from[pixels[4 * i]!]!;
}

/** Where in a picture of `width` px anything is drawn; null: nowhere. `right` and `bottom` are the first beyond. */
export function drawnBox(
  pixels: Uint8ClampedArray,
  width: number,
): { left: number; top: number; right: number; bottom: number } | null {
  const height = pixels.length / 4 / width;
  let [left, right, top, bottom] = [width, 0, height, 0];
  for (let row = 0; row < height; row++)
    for (let column = 0; column < width; column++)
      if (pixels[4 * (row * width + column) + 3]! > 0) {
        if (column < left) left = column;
        if (column >= right) right = column + 1;
        if (row < top) top = row;
        bottom = row + 1;
      }
  return right > left ? { left, top, right, bottom } : null;
}

function mapColor(value: number): Rgba {
  if (value === UNKNOWN_CELL) return NOTHING;
  const share = Math.min(100, value) / 100;
  const mix = (i: 0 | 1 | 2) => FREE[i] + (OCCUPIED[i] - FREE[i]) * share;
  return [mix(0), mix(1), mix(2), 255];
}

function costColor(value: number): Rgba {
  if (value === UNKNOWN_CELL || value === 0) return NOTHING;
  return [...COST, 40 + 1.75 * Math.min(100, value)];
}
