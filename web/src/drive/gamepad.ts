/** Reads a gamepad: which of the pads there are, whether its dead-man is held, and where its sticks are. Pure. */

import type { Axes } from "./axes";

/** What is used of the browser's Gamepad. */
export interface PadSnapshot {
  id: string;
  index: number;
  connected: boolean;
  axes: readonly number[];
  buttons: readonly { pressed: boolean }[];
}

export interface PadReading {
  /** The pad in use: the first whose dead-man was pressed, kept until it is unplugged. */
  chosen: { id: string; index: number } | null;
  /** Null while the dead-man is not held. */
  axes: Axes | null;
  /** A trigger is held: what stands in the way stops nothing. */
  override: boolean;
  /** The stop button (B or circle) is down, on any pad. */
  stop: boolean;
  /** The button that sends the robot back to the start (Y or triangle) is down, on any pad. */
  home: boolean;
}

const DEADBAND = 0.12;
const EXPO = 0.6;
const DEAD_MAN_BUTTONS = [4, 5]; // the shoulders
const OVERRIDE_BUTTONS = [6, 7]; // the triggers
const STOP_BUTTON = 1;
const HOME_BUTTON = 3;

/** `strafes`: the body moves sideways. */
export function readPads(
  pads: readonly (PadSnapshot | null)[],
  chosen: PadReading["chosen"],
  strafes = false,
): PadReading {
  const usable = pads.filter(
    (pad): pad is PadSnapshot => !!pad && pad.connected && pad.axes.length >= 2 && pad.buttons.length > 5,
  );
  const anywhere = (button: number) => usable.some((pad) => pad.buttons[button]?.pressed);
  const buttons = { stop: anywhere(STOP_BUTTON), home: anywhere(HOME_BUTTON) };
  const pad = chosen
    ? usable.find((candidate) => candidate.id === chosen.id && candidate.index === chosen.index)
    : usable.find(deadManHeld);
  if (!pad) return { chosen: null, axes: null, override: false, ...buttons };
  return {
    chosen: { id: pad.id, index: pad.index },
    axes: deadManHeld(pad) ? axesOfPad(pad, strafes) : null,
    override: held(pad, OVERRIDE_BUTTONS),
    ...buttons,
  };
}

/** Deadband, then a curve that is gentle near the centre and reaches 1 at the edge. */
export function shape(value: number): number {
  const size = Math.abs(value);
  if (!Number.isFinite(value) || size <= DEADBAND) return 0;
  const reach = Math.min(1, (size - DEADBAND) / (1 - DEADBAND));
  return Math.sign(value) * ((1 - EXPO) * reach + EXPO * reach ** 3);
}

function deadManHeld(pad: PadSnapshot): boolean {
  return held(pad, DEAD_MAN_BUTTONS);
}

function held(pad: PadSnapshot, buttons: readonly number[]): boolean {
  return buttons.some((button) => pad.buttons[button]?.pressed);
}

/**
 * Left stick forward and back. Sideways, the left stick strafes and the right one turns; a body that cannot strafe is
 * turned with whichever is pushed further. Sticks point down and right.
 */
function axesOfPad(pad: PadSnapshot, strafes: boolean): Axes {
  const left = pad.axes[0] ?? 0;
  const right = pad.axes[2] ?? 0;
  const turn = strafes || Math.abs(right) > Math.abs(left) ? right : left;
  const lateral = strafes ? -shape(left) + 0 : 0;
  return { linear: -shape(pad.axes[1] ?? 0) + 0, angular: -shape(turn) + 0, lateral };
}
