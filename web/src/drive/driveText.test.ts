import { expect, test } from "vitest";
import { heldWords } from "./driveText";

test("a driver reads what letting go does", () => {
  expect(heldWords("keyboard", false, false)).toBe("Driving by keyboard. Let go to stop.");
  expect(heldWords("stick", true, false)).toBe("Driving by stick, slowly. Let go to stop.");
});

test("with a goal, letting go does not stop the robot", () => {
  expect(heldWords("keyboard", false, true)).toBe("Driving by keyboard. Let go to continue to the goal.");
});
