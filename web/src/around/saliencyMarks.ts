/** From what stands out around the head to what is drawn and said of it. Pure. */

import { listed, t } from "../i18n";
import type { SaliencyMap, SalientRegion, SalientRegions } from "../protocol/types";
import { directionWords } from "./perceptMarks";
import { type Point, place, type Strip, scale } from "./stripProjection";

/** Nothing newer than this (s): nobody desires it any more. */
const FRESH_S = 1.5;
/** Of 255: the faintest that is drawn, and the opacity of the most. */
const LEAST = 12;
const MOST_OPAQUE = 0.55;
/** What gives less than this share to a region is not named. */
const NAMED = 0.2;
const HEAT = [255, 96, 32] as const;
const WORDS = { motion: "motion", color: "colour", contrast: "contrast", faces: "a face", sounds: "sound" } as const;

/** `rank`: 1 is the most salient; angles in rad. */
export interface RegionMark {
  rank: number;
  azimuth: number;
  elevation: number;
  /** "1: motion and sound, 30° left" */
  text: string;
}

/** Whether a message is of now. */
export function fresh(message: { stamp: number } | null, now: number): boolean {
  return message !== null && Math.abs(now - message.stamp) < FRESH_S;
}

export function regionMarks(message: SalientRegions | null, now: number): RegionMark[] {
  if (!message || !fresh(message, now)) return [];
  return message.regions.map((region, index) => ({
    rank: index + 1,
    azimuth: region.azimuth,
    elevation: region.elevation,
    text: `${index + 1}: ${featureWords(region)}, ${directionWords(region.azimuth)}`,
  }));
}

/** "motion and a face": what made a region, the most important first. */
export function featureWords(region: SalientRegion): string {
  const names = (Object.keys(WORDS) as (keyof typeof WORDS)[])
    .filter((name) => region[name] >= NAMED * region.saliency && region[name] > 0)
    .sort((a, b) => region[b] - region[a])
    .map((name) => t(WORDS[name]));
  return listed(names) || t("nothing");
}

/** All in words: "most salient 30° left (motion)"; empty for nothing. */
export function saliencySummary(message: SalientRegions | null, now: number): string {
  const first = fresh(message, now) ? message!.regions[0] : undefined;
  return first
    ? t("most salient {direction} ({features})", {
        direction: directionWords(first.azimuth),
        features: featureWords(first),
      })
    : "";
}

/** The mark within `reach` px of a point, else none. */
export function markAt(marks: RegionMark[], strip: Strip, at: Point, reach: number): RegionMark | null {
  const distances = marks.map((mark) => {
    const { x, y } = place(strip, mark.azimuth, mark.elevation);
    const across = Math.abs(at.x - x);
    return Math.hypot(Math.min(across, strip.width - across), at.y - y);
  });
  const nearest = distances.indexOf(Math.min(...distances));
  return nearest >= 0 && distances[nearest]! <= reach ? marks[nearest]! : null;
}

export interface Heat {
  width: number;
  height: number;
  /** RGBA, rows from the top down. */
  pixels: Uint8ClampedArray<ArrayBuffer>;
}

/** A pixel for each cell: the more salient, the less transparent. */
export function heat({ cells }: SaliencyMap): Heat {
  const [width, height] = [cells[0]?.length ?? 0, cells.length];
  const pixels = new Uint8ClampedArray(4 * width * height);
  cells.forEach((row, y) => {
    row.forEach((value, x) => {
      const opacity = Math.max(0, value - LEAST) / (255 - LEAST);
      pixels.set([...HEAT, 255 * MOST_OPAQUE * Math.sqrt(opacity)], 4 * (y * width + x));
    });
  });
  return { width, height, pixels };
}

/** Where the cells go on the strip; their rows reach as far over level as under it. */
export function heatBox(strip: Strip, { step, cells }: SaliencyMap): Point & Strip {
  const height = cells.length * step * scale(strip);
  return { x: 0, y: (strip.height - height) / 2, width: strip.width, height };
}
