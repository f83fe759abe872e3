import { expect, test } from "vitest";
import { noneFound } from "./foundText";

test("a robot with wheels is to be driven up to a code", () => {
  expect(noneFound({ drives: true, places: true }, false)).toMatch(/Drive to within 2 to 4 m of a code/);
});

test("what cannot drive is shown the code, and what cannot place it shows it in the picture", () => {
  expect(noneFound({ drives: false, places: true }, false)).toMatch(/Hold a code less than 2 m from the camera/);
  const words = noneFound({ drives: false, places: false }, false);
  expect(words).toMatch(/no distances.*framed there/);
  expect(words).not.toMatch(/[Dd]rive/);
});

test("in a recording nothing can be done", () => {
  expect(noneFound({ drives: false, places: true }, true)).toBe("None so far in this recording.");
});
