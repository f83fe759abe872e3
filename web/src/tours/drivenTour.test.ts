import { expect, test } from "vitest";
import type { Landmark } from "../protocol/types";
import { drivenOn, newDrivenTour, tourOf, without } from "./drivenTour";

const poster = (id: number, text: string, sightings: number, last_seen = id, frame = "map"): Landmark => ({
  text,
  id,
  x: id,
  y: 0,
  z: 1.25,
  sigma_m: 0.03,
  sightings,
  first_seen: 0,
  last_seen,
  heading: 0,
  heading_sigma: 0.1,
  frame,
});
const OLD = poster(1, "tour:lab", 9);

test("what is seen on the way is met once, in the order of meeting", () => {
  let tour = newDrivenTour("The lab", "en", [OLD]);
  expect(tour.met).toEqual([]);
  expect(drivenOn(tour, [OLD])).toBe(tour);
  tour = drivenOn(tour, [OLD, poster(3, "tour:desk", 1, 8), poster(2, "tour:door", 1, 7)]);
  expect(tour.met.map(({ text }) => text)).toEqual(["tour:door", "tour:desk"]);
  tour = drivenOn(tour, [poster(1, "tour:lab", 10, 9), poster(3, "tour:desk", 5, 9), poster(2, "tour:door", 4, 9)]);
  expect(tour.met.map(({ landmark }) => landmark)).toEqual([2, 3, 1]);
});

test("a poster counts once its place on the map is known", () => {
  let tour = drivenOn(newDrivenTour("The lab", "en", []), [poster(0, "tour:lab", 4, 1, "odom")]);
  expect(tour.met).toEqual([]);
  tour = drivenOn(tour, [poster(1, "tour:lab", 4)]);
  expect(tour.met).toEqual([{ text: "tour:lab", landmark: 1, x: 1, y: 0 }]);
});

test("one that is taken out stays out", () => {
  let tour = drivenOn(newDrivenTour("The lab", "en", []), [poster(1, "a", 1), poster(2, "b", 1)]);
  tour = without(tour, 1);
  expect(drivenOn(tour, [poster(1, "a", 1), poster(2, "b", 1)]).met.map(({ text }) => text)).toEqual(["b"]);
});

test("it becomes a tour with a stop before each", () => {
  const met = [poster(1, "HBBA:STOP/ARM", 1), poster(2, "tour:door", 1), poster(4, "tour:door", 1), poster(5, "x", 1)];
  const tour = drivenOn(newDrivenTour("The lab", "en", []), met);
  const places = new Map([
    [1, "arm-place"],
    [2, "door"],
    [4, "door-2"],
  ]);
  const made = tourOf(tour, "ground", ["the-lab"], places);
  expect(made).toMatchObject({ id: "the-lab-2", map: "ground", title: { en: "The lab" } });
  expect(made.stops.map(({ id, place, poster: text }) => [id, place, text])).toEqual([
    ["arm", "arm-place", "HBBA:STOP/ARM"],
    ["door", "door", "tour:door"],
    ["door-2", "door-2", null],
  ]);
});
