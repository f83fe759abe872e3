import { expect, test } from "vitest";
import { noneFound } from "./foundText";

test("whoever has wheels is told to drive up to a code", () => {
  expect(noneFound({ drives: true, places: true }, false)).toMatch(/Drive up to a poster: .* 2 m .* 4 m /);
});

test("what cannot drive is shown the code, and what cannot place it shows it in the picture", () => {
  expect(noneFound({ drives: false, places: true }, false)).toMatch(/Hold one before the camera/);
  const words = noneFound({ drives: false, places: false }, false);
  expect(words).toMatch(/no distances.*Held into the picture/);
  expect(words).not.toMatch(/[Dd]rive/);
});

test("in a recording nothing can be done", () => {
  expect(noneFound({ drives: false, places: true }, true)).toBe("None by this moment of the recording.");
});
