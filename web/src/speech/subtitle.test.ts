import { describe, expect, it } from "vitest";
import type { Message } from "../state/latest";
import { STAYS_S, subtitleOf } from "./subtitle";

const SPEECH: Message<"speech"> = {
  type: "speech",
  stamp: 100,
  state: "speaking",
  text: "Come here, robot.",
  word_begin: 5,
  word_end: 10,
  viseme: "open",
  language: "en",
  desire: "d-1",
  waiting: 0,
};

describe("subtitleOf", () => {
  it("marks the word that is said", () => {
    expect(subtitleOf(SPEECH, 100)).toEqual({ before: "Come ", word: "here,", after: " robot." });
  });

  it("counts characters as the robot does", () => {
    const speech = { ...SPEECH, text: "🤖 hello", word_begin: 2, word_end: 7 };
    expect(subtitleOf(speech, 100)).toEqual({ before: "🤖 ", word: "hello", after: "" });
  });

  it("stays for a moment after the last word", () => {
    const over = { ...SPEECH, state: "silent" as const, word_begin: 0, word_end: 0 };
    expect(subtitleOf(over, 100 + STAYS_S)).toEqual({ before: SPEECH.text, word: "", after: "" });
    expect(subtitleOf(over, 100.1 + STAYS_S)).toBeNull();
    expect(subtitleOf(over, null)).toBeNull();
  });

  it("is not there before anything was said", () => {
    expect(subtitleOf(null, 100)).toBeNull();
    expect(subtitleOf({ ...SPEECH, state: "silent", text: "" }, 100)).toBeNull();
  });
});
