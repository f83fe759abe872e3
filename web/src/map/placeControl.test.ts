import { expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Landmark, Place } from "../protocol/types";
import { createStore } from "../state/store";
import { PlaceControl, placeNameProblem, placeOf, posterLack } from "./placeControl";

const place = (id: string, more: Partial<Place> = {}): Place => ({
  id,
  name: id.toUpperCase(),
  x: 1,
  y: 2,
  heading: 0,
  source: "hand",
  poster: "",
  landmark: 0,
  problem: "",
  etag: `"${id}"`,
  ...more,
});

function page(made: Place, refusal: Problem | null = null) {
  const answer = vi.fn(async () => {
    if (refusal) throw refusal;
    return made;
  });
  const rest = { addPlace: answer, changePlace: answer, deletePlace: answer };
  const store = createStore();
  const places = new PlaceControl(store, rest as unknown as Rest);
  return { answer, places, store, said: () => store.notices.value.map(({ level, text }) => [level, text]) };
}

test("a place before a poster is of that one of its text", async () => {
  const { answer, places, said } = page(place("lab"));
  expect(await places.addBefore({ text: "tour:lab", x: 3, y: 4 } as Landmark)).toBe(true);
  expect(answer).toHaveBeenCalledWith({ poster: { text: "tour:lab", near: [3, 4] } });
  expect(said()).toEqual([["info", "New place: LAB."]]);
});

test("a place where the robot cannot stand is made and says so", async () => {
  const { places, said } = page(place("lab", { problem: "it is in an obstacle of the map" }));
  await places.addHere();
  expect(said()).toEqual([["warning", "New place: LAB. It is in an obstacle of the map."]]);
});

test("a refusal is shown and changes nothing", async () => {
  const { answer, places, said } = page(place("lab"), new Problem(412, "Changed", "It was changed since you read it."));
  const seen = place("lab");
  expect(await places.rename(seen, "Lab")).toBe(false);
  expect(answer).toHaveBeenCalledWith(seen, { name: "Lab" });
  expect(said()).toEqual([["error", "It was changed since you read it."]]);
  expect(places.busy.value).toBe(false);
});

test("it is there where the program keeps places", () => {
  const { places, store } = page(place("lab"));
  expect(places.kept.value).toBe(false);
  store.latest.put({ type: "places", places: [place("a")] });
  expect(places.kept.value).toBe(true);
  expect(places.all.value.map(({ id }) => id)).toEqual(["a"]);
});

test("a place needs a poster on the map that faces some way", () => {
  expect(posterLack({ frame: "odom", heading: 1 })).toContain("start SLAM");
  expect(posterLack({ frame: "map", heading: null })).toContain("Which way it faces");
  expect(posterLack({ frame: "map", heading: 0 })).toBe("");
});

test("the place of a poster is found by its landmark, not by its text alone", () => {
  const places = [place("a", { poster: "lab", landmark: 1 }), place("b", { poster: "lab", landmark: 2 })];
  expect(placeOf(places, { id: 2, text: "lab" })?.id).toBe("b");
  expect(placeOf(places, { id: 3, text: "lab" })).toBeNull();
});

test("names are needed, short, and of one place each", () => {
  const [a, b] = [place("a"), place("b")];
  expect(placeNameProblem([a, b], " ", a)).toBe("A name is needed.");
  expect(placeNameProblem([a, b], "x".repeat(61), a)).toBe("At most 60 characters.");
  expect(placeNameProblem([a, b], "B ", a)).toBe("Another place has this name.");
  expect(placeNameProblem([a, b], "A", a)).toBe("");
});
