/** What a gamepad's sticks and buttons do, for each kind of pad. Pure, but for where it is kept. */

export interface PadMapping {
  /** Axes that drive forward, turn and move sideways; of several that turn the one pushed further does. */
  forward: number;
  turn: readonly number[];
  lateral: number;
  /** By axis: whether it points the other way than sticks do (down and right are positive). */
  inverted: readonly number[];
  /** Held, they let the pad drive. */
  deadMan: readonly number[];
  override: readonly number[];
  stop: number;
  home: number;
  /** What is no push yet, 0 to 0.5. */
  deadband: number;
  /** How gentle the middle is, 0 (straight) to 1. */
  expo: number;
}

/** The standard mapping of the Gamepad API: left stick, right stick turns too; shoulders, triggers, B and Y. */
export const STANDARD: PadMapping = {
  forward: 1,
  turn: [2, 0],
  lateral: 0,
  inverted: [],
  deadMan: [4, 5],
  override: [6, 7],
  stop: 1,
  home: 3,
  deadband: 0.12,
  expo: 0.6,
};

const KEY = "hbba.pad.";

/** The mapping of the pad `id`, as kept in this browser; the standard one where none, or a damaged one, is. */
export function mappingOf(id: string, storage: Pick<Storage, "getItem">): PadMapping {
  try {
    return checked(JSON.parse(storage.getItem(KEY + id) ?? "null")) ?? STANDARD;
  } catch {
    return STANDARD;
  }
}

export function keepMapping(id: string, mapping: PadMapping, storage: Pick<Storage, "setItem">): void {
  storage.setItem(KEY + id, JSON.stringify(mapping));
}

/** `made` if it is a mapping that can drive safely: its dead-man is no other button, and none is missing. */
export function checked(made: unknown): PadMapping | null {
  if (typeof made !== "object" || made === null) return null;
  const { forward, turn, lateral, inverted, deadMan, override, stop, home, deadband, expo } = made as PadMapping;
  const index = (value: unknown) => Number.isInteger(value) && (value as number) >= 0 && (value as number) < 64;
  const indices = (value: unknown) => Array.isArray(value) && value.every(index);
  const share = (value: unknown, most: number) => typeof value === "number" && value >= 0 && value <= most;
  if (![forward, lateral, stop, home].every(index)) return null;
  if (![turn, inverted, deadMan, override].every(indices)) return null;
  if (turn.length === 0 || deadMan.length === 0 || !share(deadband, 0.5) || !share(expo, 1)) return null;
  if ([...override, stop, home].some((button) => deadMan.includes(button))) return null;
  return { forward, turn, lateral, inverted, deadMan, override, stop, home, deadband, expo };
}

/** Deadband, then a curve that is gentle near the centre and reaches 1 at the edge. */
export function shape(value: number, { deadband, expo }: Pick<PadMapping, "deadband" | "expo"> = STANDARD): number {
  const size = Math.abs(value);
  if (!Number.isFinite(value) || size <= deadband) return 0;
  const reach = Math.min(1, (size - deadband) / (1 - deadband));
  return Math.sign(value) * ((1 - expo) * reach + expo * reach ** 3);
}

/** The axis that was moved clearly from where it was; null: none. */
export function movedAxis(before: readonly number[], now: readonly number[]): number | null {
  const moves = now.map((value, axis) => Math.abs(value - (before[axis] ?? 0)));
  const most = Math.max(...moves);
  return most > 0.6 ? moves.indexOf(most) : null;
}

/** The button pressed that was not; null: none. */
export function pressedButton(before: readonly boolean[], now: readonly boolean[]): number | null {
  const found = now.findIndex((pressed, button) => pressed && !before[button]);
  return found < 0 ? null : found;
}
