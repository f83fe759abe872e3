/**
 * The operator's inputs, as a pure state machine: inputs in, drive commands out.
 *
 * Everything is under a held dead-man: a key, the stick under a finger, or a gamepad's shoulder button. A `release`
 * (blur, hidden tab, lost pointer, unplugged pad, stale view) forgets everything that is held, and what was held must
 * be released and pressed again before it drives. A command goes out at once on every change and with every
 * `tick` (50 ms) while held; a release is said three times.
 *
 * The override is a hold of its own beside the dead-man (a key, a trigger, a button on screen): by itself it does
 * nothing, and a release ends it likewise.
 *
 * The head is a hold of its own, too, by its keys or its stick, with the base or alone. Where the head follows the view,
 * that is a hold of the view: it turns the head where no hand does, and the base where no hand turns it.
 */

import { type Axes, CENTRE, type HeadAxes } from "./axes";
import { axesOfKeys, DRIVE_KEYS, HEAD_KEYS, headAxesOfKeys, OVERRIDE_KEYS, SLOW_KEYS, STRAFE_KEYS } from "./keys";

export type Source = "stick" | "gamepad" | "keyboard";

export interface Command extends Axes, HeadAxes {
  seq: number;
  held: boolean;
  override: boolean;
  head_held: boolean;
}

export type Input =
  | { type: "key"; code: string; down: boolean; repeat?: boolean }
  | { type: "stick-start"; axes: Axes }
  | { type: "stick-move"; axes: Axes }
  | { type: "stick-end" }
  | { type: "head-start"; axes: HeadAxes }
  | { type: "head-move"; axes: HeadAxes }
  | { type: "head-end" }
  | { type: "pad"; axes: Axes | null; override?: boolean }
  | { type: "follow"; axes: FollowAxes | null }
  | { type: "override"; held: boolean }
  | { type: "preset"; factor: number }
  | { type: "allow"; allowed: boolean }
  | { type: "release" }
  | { type: "tick" };

/** What the view asks of head and base, −1…1, left positive. */
export interface FollowAxes {
  pan: number;
  angular: number;
}

export interface DriveState {
  readonly allowed: boolean;
  readonly keys: ReadonlySet<string>;
  readonly stick: Axes | null;
  readonly headStick: HeadAxes | null;
  readonly pad: Axes | null;
  readonly follow: FollowAxes | null;
  /** The pad's dead-man was held through a release: it counts again once it has been let go. */
  readonly padSpent: boolean;
  /** The override is held on the pad, on screen. */
  readonly padOverride: boolean;
  readonly screenOverride: boolean;
  readonly factor: number;
  /** Which hand drives; the first to be held keeps the wheel until it lets go. */
  readonly source: Source | null;
  readonly command: Command;
  /** How often `held: false` has still to be said. */
  readonly farewells: number;
}

export interface Step {
  state: DriveState;
  send: Command[];
}

export const TICK_MS = 50;
const SLOW_FACTOR = 0.4;
const FAREWELLS = 3;
const STILL = { held: false, ...CENTRE, override: false, head_held: false, pan: 0, tilt: 0 };

export function initialDrive(factor: number): DriveState {
  return {
    allowed: false,
    keys: new Set(),
    stick: null,
    headStick: null,
    pad: null,
    follow: null,
    padSpent: false,
    padOverride: false,
    screenOverride: false,
    factor,
    source: null,
    command: { seq: 0, ...STILL },
    farewells: 0,
  };
}

export function step(state: DriveState, input: Input): Step {
  if (input.type === "tick") return tick(state);
  const next = take(state, input);
  return next === state ? { state, send: [] } : settle(state, next);
}

/** Every release still owed, at once: for a page that may not live to the next tick. */
export function flush(state: DriveState): Step {
  let current: Step = { state, send: [] };
  while (current.state.farewells > 0) {
    const { state: after, send } = farewell(current.state);
    current = { state: after, send: [...current.send, ...send] };
  }
  return current;
}

function take(state: DriveState, input: Exclude<Input, { type: "tick" }>): DriveState {
  switch (input.type) {
    case "key":
      return takeKey(state, input);
    case "stick-start":
      return state.allowed ? { ...state, stick: clampAxes(input.axes) } : state;
    case "stick-move":
      return state.stick ? { ...state, stick: clampAxes(input.axes) } : state;
    case "stick-end":
      return state.stick ? { ...state, stick: null } : state;
    case "head-start":
      return state.allowed ? { ...state, headStick: clampHead(input.axes) } : state;
    case "head-move":
      return state.headStick ? { ...state, headStick: clampHead(input.axes) } : state;
    case "head-end":
      return state.headStick ? { ...state, headStick: null } : state;
    case "pad":
      return takePad(state, input.axes, input.override ?? false);
    case "follow":
      return takeFollow(state, input.axes);
    case "override":
      return input.held === state.screenOverride || (input.held && !state.allowed)
        ? state
        : { ...state, screenOverride: input.held };
    case "preset":
      return { ...state, factor: clamp(input.factor, 0, 1) };
    case "allow":
      if (input.allowed === state.allowed) return state;
      return input.allowed ? { ...state, allowed: true } : { ...letGo(state), allowed: false };
    case "release":
      return letGo(state);
  }
}

function takeFollow(state: DriveState, axes: FollowAxes | null): DriveState {
  if (axes === null || !state.allowed) return state.follow ? { ...state, follow: null } : state;
  return { ...state, follow: { pan: clamp(axes.pan, -1, 1), angular: clamp(axes.angular, -1, 1) } };
}

function takeKey(state: DriveState, input: { code: string; down: boolean; repeat?: boolean }): DriveState {
  if (![DRIVE_KEYS, HEAD_KEYS, STRAFE_KEYS, SLOW_KEYS, OVERRIDE_KEYS].some((keys) => keys.has(input.code)))
    return state;
  if (input.down === state.keys.has(input.code)) return state;
  // A repeat of a key we do not know as held was pressed before a release: it must be pressed again.
  if (input.down && (input.repeat || !state.allowed)) return state;
  const keys = new Set(state.keys);
  if (input.down) keys.add(input.code);
  else keys.delete(input.code);
  return { ...state, keys };
}

function takePad(state: DriveState, axes: Axes | null, override: boolean): DriveState {
  if (axes === null)
    return state.pad || state.padSpent ? { ...state, pad: null, padSpent: false, padOverride: false } : state;
  if (!state.allowed) return state.padSpent ? state : { ...state, padSpent: true };
  if (state.padSpent) return state;
  const pad = clampAxes(axes);
  const unchanged = state.pad && same(state.pad, pad) && state.padOverride === override;
  return unchanged ? state : { ...state, pad, padOverride: override };
}

function letGo(state: DriveState): DriveState {
  return {
    ...state,
    keys: new Set(),
    stick: null,
    headStick: null,
    pad: null,
    follow: null,
    padSpent: state.padSpent || state.pad !== null,
    padOverride: false,
    screenOverride: false,
  };
}

function settle(before: DriveState, taken: DriveState): Step {
  const source = chooseSource(taken);
  const byHand = source ? axesOf(taken, source) : CENTRE;
  const turn = byHand.angular === 0 ? (taken.follow?.angular ?? 0) : byHand.angular;
  const axes = scale({ ...byHand, angular: turn }, factorOf(taken));
  const held = source !== null || turn !== 0;
  const override = source !== null && overrides(taken);
  const head = headAxes(taken);
  const { command: last } = before;
  const headSame = (head !== null) === last.head_held && sameHead(head ?? STILL, last);
  if (held === last.held && override === last.override && same(axes, last) && headSame)
    return { state: { ...taken, source }, send: [] };
  const { pan, tilt } = head ?? STILL;
  const command = { seq: last.seq + 1, held, ...axes, override, head_held: head !== null, pan, tilt };
  const farewells = holds(command) ? 0 : FAREWELLS - 1;
  return { state: { ...taken, source, command, farewells }, send: [command] };
}

function tick(state: DriveState): Step {
  if (!holds(state.command)) return state.farewells > 0 ? farewell(state) : { state, send: [] };
  const command = { ...state.command, seq: state.command.seq + 1 };
  return { state: { ...state, command }, send: [command] };
}

function farewell(state: DriveState): Step {
  const command = { seq: state.command.seq + 1, ...STILL };
  return { state: { ...state, command, farewells: state.farewells - 1 }, send: [command] };
}

function chooseSource(state: DriveState): Source | null {
  if (state.source && axesOfSource(state, state.source)) return state.source;
  return (["stick", "gamepad", "keyboard"] as const).find((source) => axesOfSource(state, source)) ?? null;
}

function axesOfSource(state: DriveState, source: Source): Axes | null {
  if (source === "stick") return state.stick;
  if (source === "gamepad") return state.pad;
  return axesOfKeys(state.keys);
}

function axesOf(state: DriveState, source: Source): Axes {
  return axesOfSource(state, source) ?? CENTRE;
}

/** Whether any hand holds the override, whichever drives. */
export function overrides(state: DriveState): boolean {
  return state.padOverride || state.screenOverride || [...OVERRIDE_KEYS].some((key) => state.keys.has(key));
}

/** Whether the command holds anything: the base or the head. */
export function holds(command: Command): boolean {
  return command.held || command.head_held;
}

/** Left and up of the hand that holds the head, by the speed preset; null: none does. */
function headAxes(state: DriveState): HeadAxes | null {
  const axes = state.headStick ?? headAxesOfKeys(state.keys) ?? (state.follow && { pan: state.follow.pan, tilt: 0 });
  const factor = factorOf(state);
  return axes && { pan: round(axes.pan * factor), tilt: round(axes.tilt * factor) };
}

function factorOf(state: DriveState): number {
  for (const key of state.keys) if (SLOW_KEYS.has(key)) return Math.min(state.factor, SLOW_FACTOR);
  return state.factor;
}

function scale(axes: Axes, factor: number): Axes {
  return {
    linear: round(axes.linear * factor),
    angular: round(axes.angular * factor),
    lateral: round(axes.lateral * factor),
  };
}

function clampAxes(axes: Axes): Axes {
  return {
    linear: clamp(axes.linear, -1, 1),
    angular: clamp(axes.angular, -1, 1),
    lateral: clamp(axes.lateral, -1, 1),
  };
}

function clampHead(axes: HeadAxes): HeadAxes {
  return { pan: clamp(axes.pan, -1, 1), tilt: clamp(axes.tilt, -1, 1) };
}

function clamp(value: number, low: number, high: number): number {
  return Number.isFinite(value) ? Math.max(low, Math.min(high, value)) : 0;
}

function round(value: number): number {
  return Math.round(value * 1000) / 1000 + 0; // + 0: no negative zero on the wire
}

function sameHead(a: HeadAxes, b: HeadAxes): boolean {
  return a.pan === b.pan && a.tilt === b.tilt;
}

function same(a: Axes, b: Axes): boolean {
  return a.linear === b.linear && a.angular === b.angular && a.lateral === b.lateral;
}
