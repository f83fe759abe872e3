/** Which keys drive, by physical place (`event.code`), so that they are where the hand is on every layout. */

import type { Axes, HeadAxes } from "./axes";

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
const HEAD_UP = "KeyI";
const HEAD_DOWN = "KeyK";
const HEAD_LEFT = "KeyJ";
const HEAD_RIGHT = "KeyL";
/** Held, they turn the head. */
export const HEAD_KEYS: ReadonlySet<string> = new Set([HEAD_UP, HEAD_DOWN, HEAD_LEFT, HEAD_RIGHT]);
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

/** Left and up of the keys held; null when none of them turns the head. Opposite keys cancel but still hold. */
export function headAxesOfKeys(keys: ReadonlySet<string>): HeadAxes | null {
  if (![...HEAD_KEYS].some((key) => keys.has(key))) return null;
  const held = (code: string) => (keys.has(code) ? 1 : 0);
  return { pan: held(HEAD_LEFT) - held(HEAD_RIGHT), tilt: held(HEAD_UP) - held(HEAD_DOWN) };
}
