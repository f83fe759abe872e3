/**
 * Mode 2 of the thesis (3.4): the head follows the view, and past a soft limit the base turns after it. Pure.
 *
 * Angles in degrees, left positive, by the robot's front. The base begins to turn a band beyond the limit and ends at
 * the limit, so that a view that swings about the limit does not pull at it; its speed grows from nothing, with the angle
 * and by no more than a slew each second.
 */

/** The head, forward where the base goes, and the camera orbits; or the head follows the camera. */
export type ViewMode = 1 | 2;

export const SOFT_LIMIT_DEG = 30;
export const LEAST_LIMIT_DEG = 10;
export const MOST_LIMIT_DEG = 60;
/** The base begins to turn this far beyond the limit. */
export const BAND_DEG = 8;
/** So far beyond the limit it turns at its full speed, which is this share of what a stick may ask for. */
const FULL_DEG = 30;
const FULL_SPEED = 0.6;
/** Change of the base's share of speed in a second. */
const SLEW_PER_S = 1.5;
/** The head is given its full speed this far from where it is to be; nearer than the other, it rests. */
const HEAD_FULL_DEG = 20;
const HEAD_REST_DEG = 1.5;

/** What is to be drawn of the soft limit: so far (rad) to either side of the base's heading, and whether the head is past. */
export interface SoftLimit {
  angle: number;
  past: boolean;
}

export interface Follow {
  /** The base turns, and goes on to the limit. */
  readonly turning: boolean;
  /** Shares of the greatest speeds, −1…1, left positive: of the head and of the base. */
  readonly pan: number;
  readonly angular: number;
}

export const STILL: Follow = { turning: false, pan: 0, angular: 0 };

export interface Directions {
  /** Of the view and of the head. */
  bearing: number;
  gaze: number;
}

/** What head and base are to do now, `passed` seconds after `before`. */
export function follow(before: Follow, { bearing, gaze }: Directions, limit: number, passed: number): Follow {
  if (!Number.isFinite(bearing) || !Number.isFinite(gaze)) return STILL;
  const beyond = Math.abs(bearing) - limit;
  const turning = beyond > (before.turning ? 0 : BAND_DEG);
  const wanted = turning ? Math.sign(bearing) * FULL_SPEED * Math.min(1, beyond / FULL_DEG) : 0;
  return { turning, pan: headSpeed(bearing - gaze), angular: slewed(before.angular, wanted, passed) };
}

/** Grows slowly; slows down, and ends, at once. */
function slewed(before: number, wanted: number, passed: number): number {
  if (wanted === 0 || Math.sign(wanted) !== Math.sign(before || wanted)) return 0;
  const most = Math.abs(before) + SLEW_PER_S * Math.max(0, Math.min(passed, 0.2));
  return Math.sign(wanted) * Math.min(Math.abs(wanted), most);
}

function headSpeed(error: number): number {
  if (Math.abs(error) < HEAD_REST_DEG) return 0;
  return Math.max(-1, Math.min(1, error / HEAD_FULL_DEG));
}
