import { expect, test } from "vitest";
import { inWords, Problem } from "./rest";

test("a refusal shows its reason, and its fields where the reason does not name them", () => {
  expect(inWords(new Problem(409, "Recording exists", "there is a recording called a already."))).toBe(
    "There is a recording called a already.",
  );
  expect(inWords(new Problem(404, "Not found", ""))).toBe("Not found.");
  const errors = [{ field: "name", message: "too long" }];
  expect(inWords(new Problem(422, "Invalid", "The request cannot be taken.", errors))).toBe(
    "The request cannot be taken. Too long.",
  );
  expect(inWords(new Problem(422, "Invalid", "The name is too long.", errors))).toBe("The name is too long.");
});
