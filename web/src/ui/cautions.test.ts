import { expect, test } from "vitest";
import { cautionWords } from "./cautions";

const UNMONITORED = { title: "No collision monitor", text: "nothing stops it", where: "lab.yaml:101" };
const CLOSED = { title: "Approach stays closed", text: "no strategy names it", where: "" };

test("a program that is in order needs no words", () => {
  expect(cautionWords([])).toBeNull();
});

test("one caution is said by its title, with its sentence and where it comes from", () => {
  expect(cautionWords([UNMONITORED])).toEqual({
    title: "No collision monitor",
    text: "Nothing stops it (lab.yaml:101).",
  });
});

test("of several the first is named, and all are explained", () => {
  const words = cautionWords([UNMONITORED, CLOSED])!;
  expect(words.title).toBe("No collision monitor, and 1 more");
  expect(words.text.split("\n")).toEqual(["Nothing stops it (lab.yaml:101).", "No strategy names it."]);
});
