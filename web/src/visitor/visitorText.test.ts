import { expect, test } from "vitest";
import type { VisitorView } from "../protocol/types";
import { buttonWords, doing, inLanguage, languageOf, subtitles } from "./visitorText";
import { wordsIn } from "./words";

function aView(more: Partial<VisitorView> = {}): VisitorView {
  return {
    tour: true,
    title: { en: "The lab" },
    language: "en",
    languages: ["en", "fr", "pt-br"],
    state: "presenting",
    stop_title: { en: "The arm", fr: "Le bras" },
    number: 1,
    stops: 3,
    sentences: { en: ["One.", "Two.", "Three.", "Four."], fr: ["Un et deux.", "Trois et quatre."] },
    sentence: 0,
    said: "",
    shown: null,
    press: {},
    questions: [],
    buttons: [],
    ...more,
  };
}

test("the language is the chosen one, else the browser's, else the robot's", () => {
  const view = aView();
  expect(languageOf(view, "fr", ["en"])).toBe("fr");
  expect(languageOf(view, "de", ["fr-CA", "en"])).toBe("fr"); // this tour has no German
  expect(languageOf(view, null, ["pt-PT"])).toBe("pt-br");
  expect(languageOf(view, null, ["ja"])).toBe("en");
  expect(languageOf({ ...view, language: "fr" }, null, [])).toBe("fr");
});

test("a text that a language lacks is shown in one that it has, and says in which", () => {
  const view = aView();
  expect(inLanguage(view.stop_title, "fr", view)).toEqual({ text: "Le bras", language: "fr" });
  expect(inLanguage(view.title, "fr", view)).toEqual({ text: "The lab", language: "en" });
  expect(inLanguage({ de: "Der Arm" }, "fr", view)).toEqual({ text: "Der Arm", language: "de" });
  expect(inLanguage({}, "fr", view)).toEqual({ text: "", language: "fr" });
});

test.each([
  [0, 0],
  [1, 0],
  [2, 1],
  [3, 1],
  [9, 1],
])("while sentence %i of four is said, sentence %i of two is shown", (sentence, now) => {
  expect(subtitles(aView({ sentence }), "fr")?.now).toBe(now);
});

test("in the robot's own language, its sentence is shown; without a text, nothing", () => {
  expect(subtitles(aView({ sentence: 2 }), "en")).toEqual({
    language: "en",
    sentences: ["One.", "Two.", "Three.", "Four."],
    now: 2,
  });
  expect(subtitles(aView({ sentence: 3 }), "pt-br")?.language).toBe("en");
  expect(subtitles(aView({ sentences: {} }), "en")).toBeNull();
  expect(subtitles(aView({ sentences: { en: [] } }), "en")).toBeNull();
});

test("what the robot does is said where it says nothing itself", () => {
  const words = wordsIn("en");
  expect(doing(aView({ state: "leading" }), words)).toBe("Please follow the robot.");
  expect(doing(aView({ state: "paused" }), words)).toBe("One moment, please.");
  expect(doing(aView({ state: "idle", buttons: ["start"] }), words)).toMatch("Press the button");
  expect(doing(aView({ state: "idle", buttons: [] }), words)).toMatch("soon");
  expect(doing(aView(), words)).toBe("");
});

test("buttons have the tour's words, else the page's own", () => {
  const view = aView({ press: { en: "Show me more" } });
  expect(buttonWords("next", view, "fr", wordsIn("fr"))).toBe("Show me more");
  expect(buttonWords("next", aView(), "fr", wordsIn("fr-ca"))).toBe("Continuer");
  expect(buttonWords("agree", view, "xx", wordsIn("xx"))).toBe("Yes, please");
});
