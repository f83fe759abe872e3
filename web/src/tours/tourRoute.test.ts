import { expect, test } from "vitest";
import type { Place, RouteReport } from "../protocol/types";
import { NO_STEP } from "./tourEdits";
import { itinerary, type Leg, legsOf, legWords, speechOf, tourWords } from "./tourRoute";
import { aStop, aTour } from "./tours.fixture";

const place = (id: string): Place => ({
  id,
  name: id,
  x: 0,
  y: 0,
  heading: 0,
  source: "hand",
  poster: "",
  landmark: 0,
  problem: "",
  etag: "",
});
const leg = (more: Partial<Leg> = {}): Leg => ({
  stop: "a",
  state: "way",
  reason: "",
  length_m: 12.34,
  duration_s: 90,
  path: [],
  ...more,
});

test("the way leads from home past each stop and back", () => {
  const tour = aTour([aStop("a"), aStop("b", { left_out: true }), aStop("c")], { home: "dock" });
  const way = itinerary(tour, ["a", "b", "c", "dock"].map(place));
  expect(way.points.map((point) => point.place)).toEqual(["dock", "a", "c", "dock"]);
  expect(way.to).toEqual(["a", "c", null]);
  expect(way.lacking).toEqual([]);
});

test("without a home it leads from the first stop to the last; with one stop nowhere", () => {
  const way = itinerary(aTour([aStop("a"), aStop("b")]), ["a", "b"].map(place));
  expect([way.points.map((point) => point.place), way.to]).toEqual([["a", "b"], ["b"]]);
  expect(itinerary(aTour([aStop("a")]), [place("a")]).to).toEqual([]);
  expect(itinerary(aTour([], { home: "dock" }), [place("dock")]).points).toEqual([]);
});

test("a stop whose place is gone has a leg that says so, in its turn", () => {
  const tour = aTour([aStop("a"), aStop("gone"), aStop("c")], { home: "cellar" });
  const way = itinerary(tour, ["a", "c"].map(place));
  const route: RouteReport = {
    map: "ground",
    length_m: 5,
    duration_s: 9,
    legs: [{ state: "way", reason: "", length_m: 5, duration_s: 9, path: [] }],
  };
  const legs = legsOf(tour, way, route);
  expect(legs.map(({ stop, state }) => [stop, state])).toEqual([
    ["gone", "none"],
    ["c", "way"],
    [null, "none"],
  ]);
  expect(legs[2]?.reason).toContain("cellar");
});

test("a leg is said by its length and time, or why it cannot be driven", () => {
  expect(legWords(leg())).toBe("12 m, 1.5 min");
  expect(legWords(leg({ length_m: 4.26, duration_s: 12 }))).toBe("4.3 m, 12 s");
  expect(legWords(leg({ state: "none", reason: "a wall" }))).toBe("Cannot be driven: a wall");
  expect(legWords(leg({ state: "near", reason: "it stops short" }))).toBe("12 m, 1.5 min, but it stops short");
});

test("a tour takes the time of its way and of what is said", () => {
  const say = { ...NO_STEP, say: { en: Array.from({ length: 145 }, () => "word").join(" "), fr: "mot" } };
  const tour = aTour([aStop("a", { do: [say] }), aStop("b", { do: [say], left_out: true })]);
  expect(speechOf(tour)).toBeCloseTo(60);
  const words = tourWords(tour, [leg(), leg({ state: "none" })]);
  expect(words).toEqual({ text: "12 m, 1.5 min of driving, 1 min of speech: about 2.5 min", blocked: 1 });
});
