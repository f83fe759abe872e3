/** What "all of the map" is, and where on the canvas it goes: beside what lies over that. Pure. */

import type { MapPlace } from "../state/store";
import type { Bounds, Margins, Point, Size } from "./mapProjection";

/** In the view, wider than this, the camera and the drive pad stand to the left of the map's middle (map.css). */
const ROOMY_PX = 860;
const PAD_PX = 408;
const CAMERA_PX = 330;

/** What of the canvas is free; `driven`: the robot can be driven, and the drive pad is over the view. */
export function freeOf(place: MapPlace, size: Size, driven: boolean): Margins {
  if (place === "tab") return { left: 14, top: 36, right: 46, bottom: 34 };
  if (size.width <= ROOMY_PX) return { left: 14, top: 40, right: 50, bottom: 64 };
  return { left: driven ? PAD_PX : CAMERA_PX, top: 128, right: 50, bottom: 64 };
}

/** The least rectangle around what is known and every one of `points`; null where there is nothing. */
export function around(known: Bounds | null, points: readonly Point[]): Bounds | null {
  return points.reduce<Bounds | null>(
    (bounds, { x, y }) => ({
      left: Math.min(bounds?.left ?? x, x),
      right: Math.max(bounds?.right ?? x, x),
      bottom: Math.min(bounds?.bottom ?? y, y),
      top: Math.max(bounds?.top ?? y, y),
    }),
    known,
  );
}
