/** Which keys drive, by physical place (`event.code`), so that they are where the hand is on every layout. */

import type { Axes } from "./axes";

const FORWARD = ["KeyW", "ArrowUp"];
const BACK = ["KeyS", "ArrowDown"];
const LEFT = ["KeyA", "ArrowLeft"];
const RIGHT = ["KeyD", "ArrowRight"];
const ASIDE_LEFT = ["KeyQ"];
const ASIDE_RIGHT = ["KeyE"];

export const DRIVE_KEYS: ReadonlySet<string> = new Set([...FORWARD, ...BACK, ...LEFT, ...RIGHT]);
/** Those of a body that moves sideways. */
export const STRAFE_KEYS: ReadonlySet<string> = new Set([...ASIDE_LEFT, ...ASIDE_RIGHT]);
export const SLOW_KEYS: ReadonlySet<string> = new Set(["ShiftLeft", "ShiftRight"]);
/** Held while driving: what stands in the way stops nothing, and the robot crawls. */
export const OVERRIDE_KEYS: ReadonlySet<string> = new Set(["KeyO"]);

/** Axes of the keys held; null when none of them drives. Opposite keys cancel but still hold. */
export function axesOfKeys(keys: ReadonlySet<string>): Axes | null {
  const any = (codes: string[]) => (codes.some((code) => keys.has(code)) ? 1 : 0);
  const [forward, back, left, right] = [any(FORWARD), any(BACK), any(LEFT), any(RIGHT)];
  const [asideLeft, asideRight] = [any(ASIDE_LEFT), any(ASIDE_RIGHT)];
  if (!(forward || back || left || right || asideLeft || asideRight)) return null;
  return { linear: forward - back, angular: left - right, lateral: asideLeft - asideRight };
}
