import { expect, test } from "vitest";
import { tokenIn } from "./token";

test.each([
  ["#token=abc-DEF_123", "abc-DEF_123"],
  ["#view=lanes&token=abcdefgh", "abcdefgh"],
  ["#token=a%2Bb", "a+b"],
  ["#token=", null],
  ["#tokens=abcdefgh", null],
  ["", null],
])("%s holds %s", (hash, token) => {
  expect(tokenIn(hash)).toBe(token);
});
