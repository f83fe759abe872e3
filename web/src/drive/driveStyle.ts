/**
 * Ways to drive with keys and the stick on screen, put before the state machine: hands that cannot hold, or should not
 * have to. `hold`: while held. `step`: each press moves for a moment, then stops by itself. `click`: one press goes,
 * the next stops. Pads keep their dead-man; head, slow and override keys are held in each. Pure.
 */

import { DRIVE_KEYS, STRAFE_KEYS } from "./keys";
import { type Input, TICK_MS } from "./machine";

export const STYLES = ["hold", "step", "click"] as const;
export type Style = (typeof STYLES)[number];

/** How long one step moves (ms). */
export const STEP_MS = 400;
const STEP_TICKS = STEP_MS / TICK_MS;

export interface Hands {
  readonly style: Style;
  /** The drive keys that the machine holds for the hand. */
  readonly keys: ReadonlySet<string>;
  /** The machine holds the stick. */
  readonly stick: boolean;
  /** The finger on the stick moves it: not with the press that stops. */
  readonly steers: boolean;
  /** Ticks that are left of a step. */
  readonly left: number;
}

export interface Passed {
  hands: Hands;
  inputs: Input[];
}

export function handsOf(style: Style): Hands {
  return { style, keys: new Set(), stick: false, steers: false, left: 0 };
}

/** What the machine is given for `input`. */
export function pass(hands: Hands, input: Input): Passed {
  if (input.type === "release" || (input.type === "allow" && !input.allowed))
    return { hands: handsOf(hands.style), inputs: [input] };
  if (hands.style === "hold") return { hands, inputs: [input] };
  switch (input.type) {
    case "key":
      return DRIVE_KEYS.has(input.code) || STRAFE_KEYS.has(input.code)
        ? passKey(hands, input)
        : { hands, inputs: [input] };
    case "stick-start":
      if (moves(hands)) return hands.style === "click" ? stop(hands) : { hands, inputs: [] };
      return { hands: { ...hands, stick: true, steers: true, left: STEP_TICKS }, inputs: [input] };
    case "stick-move":
      return { hands, inputs: hands.stick && hands.steers ? [input] : [] };
    case "stick-end":
      return { hands: { ...hands, steers: false }, inputs: [] };
    case "tick":
      return passTick(hands, input);
    default:
      return { hands, inputs: [input] };
  }
}

/** Another style: what is held is let go of first. */
export function restyled(hands: Hands, style: Style): Passed {
  return { hands: handsOf(style), inputs: stop(hands).inputs };
}

function passKey(hands: Hands, input: Input & { type: "key" }): Passed {
  if (!input.down || input.repeat) return { hands, inputs: [] };
  if (hands.style === "click" && moves(hands)) return stop(hands);
  const keys = new Set(hands.keys).add(input.code);
  return { hands: { ...hands, keys, left: STEP_TICKS }, inputs: [input] };
}

function passTick(hands: Hands, input: Input & { type: "tick" }): Passed {
  if (hands.style !== "step" || !moves(hands)) return { hands, inputs: [input] };
  if (hands.left > 1) return { hands: { ...hands, left: hands.left - 1 }, inputs: [input] };
  const { hands: after, inputs } = stop(hands);
  return { hands: after, inputs: [...inputs, input] };
}

function stop(hands: Hands): Passed {
  const inputs: Input[] = [...hands.keys].map((code) => ({ type: "key", code, down: false }));
  if (hands.stick) inputs.push({ type: "stick-end" });
  return { hands: handsOf(hands.style), inputs };
}

function moves({ keys, stick }: Hands): boolean {
  return keys.size > 0 || stick;
}
