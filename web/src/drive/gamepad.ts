/** Reads a gamepad: which of the pads there are, whether its dead-man is held, and where its sticks are. Pure. */

import type { Axes } from "./machine";

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
  /** The stop button (B or circle) is down. */
  stop: boolean;
}

const DEADBAND = 0.12;
const EXPO = 0.6;
const DEAD_MAN_BUTTONS = [4, 5]; // the shoulders
const STOP_BUTTON = 1;

export function readPads(pads: readonly (PadSnapshot | null)[], chosen: PadReading["chosen"]): PadReading {
  const usable = pads.filter(
    (pad): pad is PadSnapshot => !!pad && pad.connected && pad.axes.length >= 2 && pad.buttons.length > 5,
  );
  const stop = usable.some((pad) => pad.buttons[STOP_BUTTON]?.pressed);
  const pad = chosen
    ? usable.find((candidate) => candidate.id === chosen.id && candidate.index === chosen.index)
    : usable.find(deadManHeld);
  if (!pad) return { chosen: null, axes: null, stop };
  return { chosen: { id: pad.id, index: pad.index }, axes: deadManHeld(pad) ? axesOfPad(pad) : null, stop };
}

/** Deadband, then a curve that is gentle near the centre and reaches 1 at the edge. */
export function shape(value: number): number {
  const size = Math.abs(value);
  if (!Number.isFinite(value) || size <= DEADBAND) return 0;
  const reach = Math.min(1, (size - DEADBAND) / (1 - DEADBAND));
  return Math.sign(value) * ((1 - EXPO) * reach + EXPO * reach ** 3);
}

function deadManHeld(pad: PadSnapshot): boolean {
  return DEAD_MAN_BUTTONS.some((button) => pad.buttons[button]?.pressed);
}

/** Left stick forward and back; turning with whichever stick is pushed further sideways. Sticks point down and right. */
function axesOfPad(pad: PadSnapshot): Axes {
  const left = pad.axes[0] ?? 0;
  const right = pad.axes[2] ?? 0;
  const turn = Math.abs(right) > Math.abs(left) ? right : left;
  return { linear: -shape(pad.axes[1] ?? 0) + 0, angular: -shape(turn) + 0 };
}
