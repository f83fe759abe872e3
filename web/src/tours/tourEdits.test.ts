import { expect, test } from "vitest";
import type { Stop, Tour } from "../protocol/types";
import {
  does,
  NO_STEP,
  newId,
  newQuestion,
  newStop,
  newTour,
  posterTitle,
  stepChanged,
  stepMoved,
  stopChanged,
  stopMoved,
  textOf,
  withoutIdle,
  withoutStop,
  withStop,
  withText,
  withWords,
} from "./tourEdits";
import { aStop, aTour } from "./tours.fixture";

const ids = (tour: Tour) => tour.stops.map(({ id }) => id).join(" ");

test("ids are made of names, short, and of one each", () => {
  expect(newId("The arm", [])).toBe("the-arm");
  expect(newId("L'été à Sherbrooke!", [])).toBe("l-ete-a-sherbrooke");
  expect(newId("The arm", ["the-arm", "the-arm-2"])).toBe("the-arm-3");
  expect(newId("研究室", [], "tour")).toBe("tour");
  expect(newId("a".repeat(60), ["a".repeat(40)])).toBe(`${"a".repeat(38)}-2`);
});

test("a new tour has what is needed, in one language", () => {
  expect(newTour(" The  lab ", "en", "ground", ["the-lab"])).toEqual({
    format: 1,
    id: "the-lab-2",
    title: { en: "The lab" },
    languages: ["en"],
    map: "ground",
    stops: [],
  });
});

test("a poster says what its stop is about", () => {
  expect(posterTitle("tour:robotics lab")).toBe("Robotics lab");
  expect(posterTitle("HBBA:STOP/ROBOT-LAB1")).toBe("Robot lab1");
  expect(posterTitle("HBBA:STOP/ARM/EN/IT YIELDS.")).toBe("Arm");
  expect(posterTitle("Kitchen")).toBe("Kitchen");
  expect(posterTitle("tour:")).toBe("Tour:");
});

test("a stop has the id that its code names, and the poster's text", () => {
  const tour = aTour([aStop("desk")]);
  expect(newStop(tour, "lab", "The arm", "HBBA:STOP/ARM")).toMatchObject({ id: "arm", poster: "HBBA:STOP/ARM" });
  expect(newStop(tour, "lab", "Desk", "HBBA:STOP/DESK").id).toBe("desk-2");
  expect(newStop(tour, "lab", "Here")).toMatchObject({ id: "here", poster: null, title: { en: "Here" } });
});

test("stops are added, moved, changed and removed by their ids", () => {
  const tour = aTour([aStop("a"), aStop("b"), aStop("c")]);
  expect(ids(withStop(tour, aStop("d")))).toBe("a b c d");
  expect(ids(withStop(tour, aStop("d"), 1))).toBe("a d b c");
  expect(ids(stopMoved(tour, "a", 1))).toBe("b a c");
  expect(ids(stopMoved(tour, "a", 9))).toBe("b c a");
  expect(ids(stopMoved(tour, "c", -1))).toBe("c a b");
  expect(ids(stopMoved(tour, "x", 0))).toBe("a b c");
  expect(ids(withoutStop(tour, "b"))).toBe("a c");
  expect(stopChanged(tour, "b", { left_out: true }).stops.map((stop: Stop) => stop.left_out)).toEqual([
    false,
    true,
    false,
  ]);
  expect(ids(tour)).toBe("a b c");
});

test("a text that is emptied is none in that language", () => {
  expect(withText({ en: "Hello" }, "fr", "Bonjour")).toEqual({ en: "Hello", fr: "Bonjour" });
  expect(withText({ en: "Hello", fr: "Bonjour" }, "fr", " ")).toEqual({ en: "Hello" });
  expect(withText(null, "en", "Hello")).toEqual({ en: "Hello" });
  expect(textOf({ fr: "Bonjour" }, ["en", "fr"])).toBe("Bonjour");
  expect(textOf({ de: "Hallo" }, ["en"])).toBe("Hallo");
  expect(textOf(null, ["en"])).toBe("");
});

test("words to listen for are a list in small letters", () => {
  expect(withWords({}, "en", "Next, Go on,,")).toEqual({ en: ["next", "go on"] });
  expect(withWords({ en: ["next"] }, "en", " ")).toEqual({});
});

test("steps are changed and moved, and those that do nothing are dropped", () => {
  const [say, wave] = [
    { ...NO_STEP, say: { en: "Hello" } },
    { ...NO_STEP, gesture: { class: "Wave", params: {} } },
  ];
  expect(stepMoved([say, wave], 0, 1)).toEqual([wave, say]);
  expect(stepMoved([say], 4, 0)).toEqual([say]);
  const emptied = stepChanged([say, wave], 0, { say: {} });
  expect(emptied.map(does)).toEqual([false, true]);
  expect(withoutIdle(emptied)).toEqual([wave]);
});

test("each question of a stop has an id of its own", () => {
  const stop = aStop("arm");
  const first = newQuestion(stop, ["fr"]);
  expect(first).toMatchObject({ id: "question", answer: { say: { fr: "…" } } });
  expect(newQuestion({ ...stop, questions: [first] }, ["fr"]).id).toBe("question-2");
});
