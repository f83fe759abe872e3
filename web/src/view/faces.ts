/** Which faces and codes belong on the camera's picture; pure. */

import type { Perceived, SeenCode, SeenFace } from "../protocol/types";

/** The frames of the camera whose pictures the page shows: of a robot with two cameras, and of one with one. */
const CAMERAS: ReadonlySet<string> = new Set(["kinect_optical_frame", "camera_optical_frame"]);
/** Percepts and pictures are thinned by attention each in its own way: of so different stamps they go together, s. */
const APART_S = 0.6;
/** How far the robot may turn meanwhile for a frame to be still where the face is, rad. */
const TURNED = 0.06;

/** `turning`: how fast the robot turns, rad/s. */
export function facesOn(perceived: Perceived | null, stamp: number | null, turning: number): SeenFace[] {
  return together(perceived?.faces ?? [], stamp, turning);
}

/** `turning`: how fast the robot turns, rad/s. */
export function codesOn(perceived: Perceived | null, stamp: number | null, turning: number): SeenCode[] {
  return together(perceived?.codes ?? [], stamp, turning);
}

function together<T extends SeenFace | SeenCode>(seen: T[], stamp: number | null, turning: number): T[] {
  if (stamp === null) return [];
  const apart = Math.min(APART_S, turning > 0 ? TURNED / turning : APART_S);
  return seen.filter(
    (one) => CAMERAS.has(one.camera) && one.image !== null && Math.abs(one.stamp - stamp) <= Math.max(0.1, apart),
  );
}
