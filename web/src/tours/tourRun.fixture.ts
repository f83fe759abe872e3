/** How a tour goes, for tests. */

import type { Rehearsal, RehearsalReport, RunReport, TourProgress } from "../protocol/types";

export function aProgress(more: Partial<TourProgress> = {}): TourProgress {
  return {
    stamp: 100,
    run: "20261123-080000-lab",
    tour: "lab",
    title: { en: "The lab", fr: "Le labo" },
    language: "en",
    languages: ["en", "fr"],
    waits: false,
    state: "leading",
    since: 90,
    reason: "",
    stop: "arm",
    stop_title: { en: "The arm" },
    number: 2,
    stops: 3,
    step: 0,
    steps: 2,
    text: {},
    sentence: 0,
    shown: null,
    press: {},
    questions: [],
    buttons: ["pause", "skip", "end"],
    question: null,
    people: 2,
    farthest_m: 1.5,
    presented: ["door"],
    skipped: [],
    failures: [],
    ...more,
  };
}

export function aReport(more: Partial<RunReport> = {}): RunReport {
  return {
    run: "20261123-080000-lab",
    tour: "lab",
    title: { en: "The lab" },
    language: "en",
    began: 1000,
    ended: 1305,
    outcome: "the tour is over",
    agreed: true,
    people_begin: 2,
    people_most: 3,
    people_end: 2,
    driven_m: 20,
    waits: 1,
    waited_s: 10,
    pauses: 0,
    paused_s: 0,
    stops: [],
    failures: [],
    ...more,
  };
}

export function aRehearsal(more: Partial<Rehearsal> = {}): Rehearsal {
  return {
    tour: "lab",
    language: "en",
    outcome: "the tour is over",
    duration_s: 104.5,
    driven_m: 12,
    stops: ["arm"],
    states: [],
    subtitles: [],
    path: [],
    problems: [],
    ...more,
  };
}

export function aRehearsalReport(more: Partial<RehearsalReport> = {}): RehearsalReport {
  return {
    state: "running",
    tour: "lab",
    language: "en",
    began: 1000,
    seconds: 0,
    stop: "",
    problem: "",
    can_be_led: null,
    result: null,
    ...more,
  };
}
