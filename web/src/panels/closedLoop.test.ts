import { expect, test } from "vitest";
import { budgetWords } from "./closedLoopText";

test("a budget that nobody presses on is given whole", () => {
  expect(budgetWords({ budget: 44, share: 1, waiting: null })).toBe("Attention may give the whole budget.");
});

test("what others take is said, with what the program waits", () => {
  expect(budgetWords({ budget: 44, share: 0.5, waiting: 0.42 })).toBe(
    "Others press on the computer: attention gives 22 of 44 %. The program waits 42 % of its time for a core.",
  );
});
