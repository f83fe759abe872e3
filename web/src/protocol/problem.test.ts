import { afterEach, beforeEach, expect, test } from "vitest";
import { fr, robot } from "../i18n/fr";
import { shown } from "../i18n/text";
import { inWords, Problem, readProblem } from "./problem";

const ENGLISH = shown.peek();
const MESSAGE = "should be greater than 0, not -1.5";
const RULE = {
  field: "intensity",
  message: MESSAGE,
  kind: "greater_than",
  values: { gt: 0, given: "-1.5" },
};

beforeEach(() => void (shown.value = { language: "fr", tag: "fr-CA", catalogue: fr, robot }));
afterEach(() => void (shown.value = ENGLISH));

function refused(...errors: { field: string; message: string; kind?: string; values?: object }[]) {
  const detail = errors.map(({ field, message }) => `${field}: ${message}`).join("; ");
  const body = { type: "urn:hbba:problem:invalid-request", title: "Invalid request", status: 422, detail, errors };
  return readProblem(new Response(JSON.stringify(body), { status: 422 }));
}

test("a rule that is broken is said in the reader's language, with its figures", async () => {
  const problem = await refused(RULE);
  expect(problem.errors).toEqual([{ field: "intensity", message: "doit être supérieur à 0, pas -1,5" }]);
  expect(problem.detail).toBe("intensity\u202f: doit être supérieur à 0, pas -1,5");
  expect(inWords(problem)).toBe("Intensity\u202f: doit être supérieur à 0, pas -1,5.");
});

test("in English the program's own words stay", async () => {
  shown.value = ENGLISH;
  const problem = await refused(RULE);
  expect(problem.errors).toEqual([{ field: "intensity", message: MESSAGE }]);
  expect(problem.detail).toBe(`intensity: ${MESSAGE}`);
});

test("by its type alone: the same rule in other English words is said the same", async () => {
  const { errors } = await refused({ ...RULE, message: "wants something else" });
  expect(errors[0]!.message).toBe("doit être supérieur à 0, pas -1,5");
});

test.each([
  ["missing", {}, "manque"],
  ["less_than_equal", { le: 8.5, given: "9" }, "doit être au plus 8,5, pas 9"],
  ["string_too_long", { max_length: 60, given: "'x'" }, "trop long\u202f: longueur d’au plus 60 caractère(s), pas 'x'"],
  [
    "literal_error",
    { expected: "'keep_out', 'slow'", given: "'fast'" },
    "doit être l’une de ces valeurs\u202f: 'keep_out', 'slow'\u202f; pas 'fast'",
  ],
  ["list_type", { given: "nothing" }, "doit être une liste, pas rien"],
  ["too_short", { min_length: 3, actual_length: 2, given: "a list" }, "doit avoir au moins 3 élément(s), pas 2"],
  ["bool_type", { given: "'yes'" }, "doit être vrai ou faux, pas 'yes'"],
])("%s", async (kind, values, words) => {
  const { errors } = await refused({ field: "f", message: "English", kind, values });
  expect(errors[0]!.message).toBe(words);
});

test("a rule of the program's own is said by its sentence", async () => {
  const sentence = "should be printable, without spaces before or after it";
  const { errors } = await refused({
    field: "name",
    message: `${sentence}, not ' a'`,
    kind: "value_error",
    values: { error: sentence, given: "' a'" },
  });
  expect(errors[0]!.message).toBe("doit être imprimable, sans espaces avant ni après");
});

test("where one fault has no rule, the program's detail stays beside it", async () => {
  const other = { field: "class", message: "no desire class is called 'x'" };
  const problem = await refused(RULE, other);
  expect(problem.detail).toContain("greater than");
  expect(problem.errors[1]).toEqual(other);
  expect((await refused({ ...RULE, kind: "of_tomorrow" })).errors[0]!.message).toBe(MESSAGE);
});

test("a refusal shows its reason, and its fields where the reason does not name them", () => {
  shown.value = ENGLISH;
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
