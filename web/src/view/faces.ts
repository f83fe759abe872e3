/** Which faces and codes belong on the camera's picture, and where they are on it; pure. */

import type { Perceived, SeenCode, SeenFace } from "../protocol/types";

/** The frames of the camera whose pictures the page shows: of a robot with two cameras, and of one with one. */
const CAMERAS: ReadonlySet<string> = new Set(["kinect_optical_frame", "camera_optical_frame"]);
/** Percepts and pictures are thinned by attention each in its own way: of so different stamps they go together, s. */
const APART_S = 0.6;
/** How far the camera may turn meanwhile for a frame to be still where the face is, rad. */
const TURNED = 0.06;

/** A picture and what is seen in it have one stamp; less than this is rounding, s. */
const LEAST_APART_S = 0.01;

/** The sightings of a face are kept so long, and its velocity is estimated from them, s. */
const KEPT_S = 2;
const FIT_S = 0.6;

type Box = SeenFace["box"];

/** Where each face was seen of late, by its track and camera; stamps ascending. */
export type Trails = ReadonlyMap<string, readonly SeenFace[]>;

/** With what is perceived now. */
export function trailed(trails: Trails, perceived: Perceived | null): Trails {
  const next = new Map<string, readonly SeenFace[]>();
  for (const face of perceived?.faces ?? []) {
    const before = trails.get(keyOf(face)) ?? [];
    const last = before.at(-1);
    // Time of a recording may have gone back.
    const older = last && face.stamp < last.stamp ? [] : before;
    const kept = older.filter(({ stamp }) => stamp < face.stamp && face.stamp - stamp <= KEPT_S);
    next.set(keyOf(face), [...kept, face]);
  }
  return next;
}

/**
 * The faces on the picture of `stamp`, each where it is there: between two sightings as far along as the picture is, after
 * the last one as it moved. Faces are found some tenths of a second after the picture is shown.
 * `turning`: how fast the camera turns, rad/s.
 */
export function facesOn(trails: Trails, stamp: number | null, turning: number): SeenFace[] {
  const newest = [...trails.values()].map((trail) => trail.at(-1)!);
  return together(newest, stamp, turning).map((face) => ({ ...face, box: boxAt(trails.get(keyOf(face))!, stamp!) }));
}

function boxAt(trail: readonly SeenFace[], stamp: number): Box {
  const last = trail.at(-1)!;
  const after = trail.findIndex((face) => face.stamp >= stamp);
  if (after === 0) return trail[0]!.box;
  if (after > 0) {
    const [one, other] = [trail[after - 1]!, trail[after]!];
    const share = (stamp - one.stamp) / (other.stamp - one.stamp);
    return one.box.map((value, index) => value + share * (other.box[index]! - value)) as Box;
  }
  const { x, y } = velocity(trail.filter((face) => last.stamp - face.stamp <= FIT_S));
  const [left, top, width, height] = last.box;
  const ahead = stamp - last.stamp;
  return [left + x * ahead, top + y * ahead, width, height];
}

/** Of the middle of the box, px/s: the slopes of the lines through all sightings. */
function velocity(trail: readonly SeenFace[]): { x: number; y: number } {
  const mean = (of: (face: SeenFace) => number) => trail.reduce((sum, face) => sum + of(face), 0) / trail.length;
  const t = mean((face) => face.stamp);
  const spread = mean((face) => (face.stamp - t) ** 2);
  if (spread === 0) return { x: 0, y: 0 };
  const slope = (of: (face: SeenFace) => number) => mean((face) => (face.stamp - t) * of(face)) / spread;
  return { x: slope(({ box }) => box[0] + box[2] / 2), y: slope(({ box }) => box[1] + box[3] / 2) };
}

function keyOf({ track, camera }: SeenFace): string {
  return `${track} ${camera}`;
}

/** `turning`: how fast the camera turns, rad/s. */
export function codesOn(perceived: Perceived | null, stamp: number | null, turning: number): SeenCode[] {
  return together(perceived?.codes ?? [], stamp, turning);
}

function together<T extends SeenFace | SeenCode>(seen: T[], stamp: number | null, turning: number): T[] {
  if (stamp === null) return [];
  const apart = Math.min(APART_S, turning > 0 ? TURNED / turning : APART_S);
  return seen.filter((one) => CAMERAS.has(one.camera) && Math.abs(one.stamp - stamp) <= Math.max(LEAST_APART_S, apart));
}

/** At which side of the picture a frame is, px: its words start or end there and not at its middle, to be seen whole. */
export function nearSide(left: number, width: number, across: number): "left" | "right" | "" {
  const middle = left + width / 2;
  if (middle < 0.25 * across) return "left";
  return middle > 0.75 * across ? "right" : "";
}

/** How much of a frame's width is outside the picture, at the side where it is, %. */
export function cutOff(left: number, width: number, across: number): number {
  return width > 0 ? (100 * Math.max(0, -left, left + width - across)) / width : 0;
}
