import { expect, test } from "vitest";
import { keyIn, tokenIn } from "./token";

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

test("a link for visitors holds a key, and no token", () => {
  expect(keyIn("#key=abc-DEF_123")).toBe("abc-DEF_123");
  expect(keyIn("#token=abc")).toBeNull();
  expect(tokenIn("#key=abc")).toBeNull();
});
