import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { atTurns, CALM_MS, fourTimesASecond, hasCard, nextTurn, paced, untilTurn } from "./turns";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

test("of many values, the first is shown at once and the newest of a turn at its end", () => {
  const shown: number[] = [];
  const show = paced((value: number) => shown.push(value));
  for (const value of [1, 2, 3]) show(value);
  expect(shown).toEqual([1]);
  vi.advanceTimersByTime(CALM_MS);
  expect(shown).toEqual([1, 3]);
  show(4);
  expect(shown).toEqual([1, 3]); // 3 is the first of a turn
  vi.advanceTimersByTime(CALM_MS);
  expect(shown).toEqual([1, 3, 4]);
});

test("nothing is due while nothing comes", () => {
  const shown: number[] = [];
  const show = paced((value: number) => shown.push(value));
  show(1);
  vi.advanceTimersByTime(CALM_MS);
  expect(vi.getTimerCount()).toBe(0);
  show(2);
  expect(shown).toEqual([1, 2]);
});

test("the turns of a page without a card are common to all of it, whenever each part asks", () => {
  const turns: number[] = [];
  const run = () => turns.push(performance.now());
  vi.advanceTimersByTime(untilTurn(performance.now()) + 10);
  nextTurn(run);
  const end = fourTimesASecond(run);
  vi.advanceTimersByTime(CALM_MS / 2);
  nextTurn(run);
  vi.advanceTimersByTime(CALM_MS);
  end();
  expect(turns).toHaveLength(3);
  expect(new Set(turns).size).toBe(1);
  expect(turns[0]! % CALM_MS).toBeCloseTo(0);
});

test("four times a second is that, until it is ended", () => {
  let count = 0;
  const end = fourTimesASecond(() => (count += 1));
  vi.advanceTimersByTime(10_000);
  expect(count).toBe(40);
  end();
  vi.advanceTimersByTime(1000);
  expect(count).toBe(40);
  expect(vi.getTimerCount()).toBe(0);
});

test("at turns, the newest value is shown, and none before its turn", () => {
  const shown: number[] = [];
  const show = atTurns((value: number) => shown.push(value));
  for (const value of [1, 2, 3]) show(value);
  expect(shown).toEqual([]);
  vi.advanceTimersByTime(CALM_MS);
  expect(shown).toEqual([3]);
  vi.advanceTimersByTime(CALM_MS);
  expect(shown).toEqual([3]);
});

test.each([
  ["ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)", false],
  ["llvmpipe (LLVM 15.0.6, 256 bits)", false],
  ["ANGLE (Microsoft, Microsoft Basic Render Driver Direct3D11 vs_5_0 ps_5_0)", false],
  ["ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)", true],
  ["Apple M1", true],
  ["Adreno (TM) 640", true],
  [null, false],
])("the renderer %s draws on a card: %s", (name, card) => {
  expect(hasCard(name)).toBe(card);
});
