import { expect, test } from "vitest";
import type { MemoryEvent, MemoryState } from "../protocol/types";
import { eventWords, itemWords, recognizedWords, timesWords } from "./memoryText";

const there: MemoryEvent = {
  id: 1,
  items: [
    { channel: "person", item: "someone", weight: 1 },
    { channel: "person", item: "person 3", weight: 0.1 },
    { channel: "place", item: "lab/arm", weight: 1 },
    { channel: "emotion", item: "joy", weight: 0.8 },
  ],
};
const asked: MemoryEvent = {
  id: 2,
  items: [...there.items, { channel: "object", item: "word how heavy", weight: 1 }],
};
const state = (changes: Partial<MemoryState>): MemoryState => ({
  stamp: 1,
  on: true,
  problem: "",
  under_way: [],
  recognized: null,
  match: 0,
  anticipated: [],
  raised: [],
  episodes: [],
  episode_count: 0,
  event_count: 0,
  ...changes,
});

test("items in words", () => {
  const words = (channel: "person" | "object" | "place" | "desire", item: string) => itemWords({ channel, item });
  expect(words("place", "lab/arm")).toBe("at arm");
  expect(words("place", "arm")).toBe("at arm");
  expect(words("desire", "ListenForWords#a1b2c3")).toBe("Listen for words");
  expect(words("person", "someone")).toBe("someone");
  expect(words("person", "person 12")).toBe("person 12");
  expect(words("object", "word how heavy")).toBe("“how heavy”");
  expect(words("object", "code door")).toBe("code door");
  expect(words("object", "sound tonal")).toBe("sound tonal");
});

test("an event says what is new in it", () => {
  expect(eventWords(there)).toBe("someone, at arm");
  expect(eventWords(asked, there)).toBe("“how heavy”");
  expect(eventWords(there, asked)).toBe("someone, at arm");
});

test("what is recognized", () => {
  expect(recognizedWords(state({}))).toBe("Nothing happens.");
  expect(recognizedWords(state({ under_way: [there] }))).toBe("Nothing that is remembered is like this.");
  const episode = { id: 7, times: 3, first: 0, last: 100, events: 2, items: [], deeds: [] };
  const known = state({ under_way: [there], recognized: 7, match: 0.916, episodes: [episode] });
  expect(recognizedWords(known)).toBe("This is like episode 7 (92 %), which has happened 3 times.");
  expect(timesWords(episode, null)).toBe("3 times");
  expect(timesWords({ ...episode, times: 1 }, 220)).toMatch(/^once, last 2 min ago$/);
});
