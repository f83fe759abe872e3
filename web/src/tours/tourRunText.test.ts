import { expect, test } from "vitest";
import { aProgress, aReport } from "./tourRun.fixture";
import {
  badgeOf,
  controlsOf,
  defaultWords,
  idWords,
  isThere,
  isUrgent,
  pauseWords,
  peopleWords,
  reportWords,
  standsWords,
  stateWords,
  stopWords,
  timesWords,
  visitorControls,
} from "./tourRunText";

const QUESTION = {
  text: "The way to arm is blocked. Try again, or skip it?",
  answers: ["retry" as const, "skip" as const],
  default: "the stop is skipped",
  until: 120,
};

test("a tour is there while it is led, or waits for visitors", () => {
  expect(isThere(null)).toBe(false);
  expect(isThere(aProgress({ tour: "", state: "idle" }))).toBe(false);
  expect(isThere(aProgress({ state: "idle" }))).toBe(false); // it is over
  expect(isThere(aProgress({ state: "idle", waits: true }))).toBe(true);
  expect(isThere(aProgress())).toBe(true);
});

test("the tab says at which stop the tour is, and asks to be looked at where people have to decide", () => {
  expect(badgeOf(aProgress())).toBe("2/3");
  expect(badgeOf(aProgress({ number: 0, stop: "", state: "inviting" }))).toBe("on");
  expect(badgeOf(aProgress({ state: "idle", waits: true }))).toBe("");
  expect(badgeOf(null)).toBe("");
  expect(isUrgent(aProgress())).toBe(false);
  expect(isUrgent(aProgress({ state: "blocked", question: QUESTION }))).toBe(true);
  expect(isUrgent(aProgress({ state: "lost" }))).toBe(true);
});

test("where it is and who comes along, in words", () => {
  expect(stateWords(aProgress())).toBe("On its way");
  expect(stateWords(aProgress({ state: "idle", waits: true }))).toBe("Waits for visitors to begin");
  expect(stopWords(aProgress())).toBe("Stop 2 of 3: The arm");
  expect(stopWords(aProgress({ number: 0 }))).toBe("The arm");
  expect(stopWords(aProgress({ stop: "", stop_title: {} }))).toBe("");
  expect(peopleWords(aProgress())).toBe("2 visitors are seen, the farthest 1.5 m away");
  expect(peopleWords(aProgress({ people: 1 }))).toBe("1 visitor is seen, 1.5 m away");
  expect(peopleWords(aProgress({ people: 0, farthest_m: null }))).toBe("No visitors are seen");
});

test("after an emergency stop the panel says that Resume is needed, latched or released", () => {
  const paused = aProgress({ state: "paused", question: { ...QUESTION, answers: ["resume", "end"] } });
  expect(pauseWords(paused, true)).toContain("Release the emergency stop first");
  expect(pauseWords(paused, false)).toBe("Nothing moves until you press Resume.");
  expect(pauseWords({ ...paused, question: null }, false)).toContain("goes on by itself");
  expect(pauseWords(aProgress(), false)).toBe("");
  const waits = aProgress({ state: "idle", waits: true, buttons: ["start"] });
  expect(pauseWords(waits, false)).toBe("");
  const held = { ...waits, buttons: ["resume" as const] };
  expect(pauseWords({ ...waits, buttons: [] }, true)).toContain("Release the emergency stop first");
  expect(pauseWords(held, false)).toBe("Nothing moves until you press Resume.");
  expect([isUrgent(waits), isUrgent(held)]).toEqual([false, true]);
  expect(controlsOf(held, false).map(({ button, works }) => [button, works])).toEqual([["resume", true]]);
  expect(controlsOf(held, true).map(({ button, works }) => [button, works])).toEqual([["resume", false]]);
});

test("a question says what is done without an answer, and when", () => {
  expect(defaultWords(QUESTION, 101.5)).toBe("Without an answer the stop is skipped in 0:19 min.");
  expect(defaultWords(QUESTION, 500)).toBe("Without an answer the stop is skipped in 0:00 min.");
  expect(defaultWords(QUESTION, null)).toBe("Without an answer the stop is skipped.");
});

test("buttons keep their places: what does nothing now is off, not gone", () => {
  const of = (progress = aProgress(), stopped = false) =>
    controlsOf(progress, stopped).map(({ button, works }) => [button, works]);
  expect(of()).toEqual([
    ["pause", true],
    ["skip", true],
    ["undo_skip", false],
    ["repeat", false],
    ["end", true],
  ]);
  expect(of(aProgress({ state: "paused", buttons: ["end"] }))[0]).toEqual(["resume", false]);
  const paused = aProgress({ state: "paused", buttons: ["resume", "end"] });
  expect(of(paused)[0]).toEqual(["resume", true]);
  expect(of(paused, true)[0]).toEqual(["resume", false]);
  expect(of(aProgress({ state: "idle", waits: true, buttons: ["start"] }))).toEqual([["start", true]]);
});

test("what visitors say aloud can be pressed for them, in the tour's words", () => {
  const listening = aProgress({ state: "listening", buttons: ["next", "pause"], press: { fr: "Continuer" } });
  expect(visitorControls(listening).map(({ words }) => words)).toEqual(["Continuer"]);
  expect(visitorControls({ ...listening, press: {} }).map(({ words }) => words)).toEqual(["Go on"]);
  expect(visitorControls(aProgress())).toEqual([]);
});

test("a report in a line", () => {
  const stop = {
    stop: "arm",
    began: 0,
    arrived: 1,
    ended: 2,
    presented: true,
    skipped: false,
    people: 1,
    questions: {},
  };
  expect(reportWords(aReport({ stops: [stop, { ...stop, presented: false }] }))).toBe(
    "5:05 min, 3 visitors, 1 stop presented. The tour is over.",
  );
  expect(reportWords(aReport({ ended: null, outcome: "", people_most: 1 }))).toBe("1 visitor, 0 stops presented.");
});

test("a robot that stands on its way says why, as navigation does", () => {
  const stands = { state: "waiting" as const, reason: "somebody is in the way" };
  expect(standsWords(aProgress(), stands)).toBe("Somebody is in the way.");
  expect(standsWords(aProgress(), { ...stands, state: "following" })).toBe("");
  expect(standsWords(aProgress({ state: "presenting" }), stands)).toBe("");
  expect(standsWords(aProgress({ reason: "the way was blocked" }), stands)).toBe("");
  expect(standsWords(aProgress(), null)).toBe("");
});

test("a report reads as people write", () => {
  expect(timesWords(0, 0)).toBe("never");
  expect(timesWords(1, 6.4)).toBe("once, 0:06 min");
  expect(timesWords(3, 80)).toBe("3 times, 1:20 min");
  expect(idWords("robotics-lab")).toBe("Robotics lab");
  expect(idWords("")).toBe("");
});
