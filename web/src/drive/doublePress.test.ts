import { expect, test } from "vitest";
import { DoublePress } from "./doublePress";

test("two presses within 0.6 s are one double press", () => {
  const presses = new DoublePress();
  expect([0, 600, 700, 1400, 2001, 2100].map((at) => presses.press(at))).toEqual([
    false,
    true,
    false,
    false,
    false,
    true,
  ]);
});
