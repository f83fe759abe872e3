/** Reads a gamepad: which of the pads there are, whether its dead-man is held, and where its sticks are. Pure. */

import type { Axes } from "./axes";
import { type PadMapping, STANDARD, shape } from "./padMapping";

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
  /** The stop button (B or circle, unless mapped) is down, on any pad. */
  stop: boolean;
  /** The button that sends the robot back to the start (Y or triangle, unless mapped) is down, on any pad. */
  home: boolean;
}

/** `strafes`: the body moves sideways. `mappingOf`: what a pad's sticks and buttons do, by its id. */
export function readPads(
  pads: readonly (PadSnapshot | null)[],
  chosen: PadReading["chosen"],
  strafes = false,
  mappingOf: (id: string) => PadMapping = () => STANDARD,
): PadReading {
  const usable = pads.filter(
    (pad): pad is PadSnapshot => !!pad && pad.connected && pad.axes.length >= 2 && pad.buttons.length > 5,
  );
  const anywhere = (which: "stop" | "home") => usable.some((pad) => pad.buttons[mappingOf(pad.id)[which]]?.pressed);
  const buttons = { stop: anywhere("stop"), home: anywhere("home") };
  const pad = chosen
    ? usable.find((candidate) => candidate.id === chosen.id && candidate.index === chosen.index)
    : usable.find((candidate) => held(candidate, mappingOf(candidate.id).deadMan));
  if (!pad) return { chosen: null, axes: null, override: false, ...buttons };
  const mapping = mappingOf(pad.id);
  return {
    chosen: { id: pad.id, index: pad.index },
    axes: held(pad, mapping.deadMan) ? axesOfPad(pad, mapping, strafes) : null,
    override: held(pad, mapping.override),
    ...buttons,
  };
}

function held(pad: PadSnapshot, buttons: readonly number[]): boolean {
  return buttons.some((button) => pad.buttons[button]?.pressed);
}

/**
 * Of several axes that turn, the one pushed further does; on a body that moves sideways, the first alone, for another
 * may be the one that strafes. Sticks point down and right.
 */
function axesOfPad(pad: PadSnapshot, mapping: PadMapping, strafes: boolean): Axes {
  const at = (axis: number) => (mapping.inverted.includes(axis) ? -1 : 1) * (pad.axes[axis] ?? 0);
  const turns = (strafes ? mapping.turn.slice(0, 1) : mapping.turn).map(at);
  const turn = turns.reduce((most, each) => (Math.abs(each) > Math.abs(most) ? each : most), 0);
  const drives = (value: number) => -shape(value, mapping) + 0;
  return {
    linear: drives(at(mapping.forward)),
    angular: drives(turn),
    lateral: strafes ? drives(at(mapping.lateral)) : 0,
  };
}
