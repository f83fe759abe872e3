import { expect, test } from "vitest";
import type { Landmark, Place } from "../protocol/types";
import type { Message } from "../state/latest";
import type { Context } from "./canvas";
import { landmarksLayer } from "./landmarksLayer";
import type { Point } from "./mapProjection";
import { peopleLayer } from "./peopleLayer";
import { personsLayer } from "./personsLayer";
import { placesLayer } from "./placesLayer";

type OnScreen = (place: Point & { frame?: string }) => Point | null;

/** The places that a layer draws at; `known`: whether it is known where `odom` is on the map. */
function placesOf(draw: (context: Context, onScreen: OnScreen) => void, known = true) {
  const places: [number, number][] = [];
  const context = new Proxy({} as Record<string, unknown>, {
    get: (_, name) => (x: number, y: number) => {
      if (name === "arc" || name === "strokeRect") places.push([x, y]);
    },
    set: () => true,
  });
  draw(context as unknown as Context, ({ x, y, frame }) =>
    known || frame === "map" ? { x: 10 * x, y: 10 * y } : null,
  );
  return places;
}

test("a person is drawn where the distance is known", () => {
  const perceived = {
    type: "perceived",
    faces: [
      { x: 1, y: 2 },
      { x: null, y: null },
    ],
  } as unknown as Message<"perceived">;
  expect(placesOf((context, onScreen) => peopleLayer.draw(context, perceived, onScreen))).toEqual([[10, 20]]);
});

test("a place is drawn on the map with its heading, also while it is not known where odom is", () => {
  const turns: number[] = [];
  const context = new Proxy({} as Record<string, unknown>, {
    get: (_, name) => (value: number) => {
      if (name === "rotate") turns.push(value);
      return { width: 0 };
    },
    set: () => true,
  });
  const place = { name: "Lab", x: 1, y: 2, heading: Math.PI / 2, problem: "" } as Place;
  const message = { type: "places" as const, places: [place] };
  placesLayer.draw(context as unknown as Context, message, ({ x, y, frame }) =>
    frame === "map" ? { x: 10 * x, y: -10 * y } : null,
  );
  expect(turns).toEqual([expect.closeTo(-Math.PI / 2)]);
});

test("nothing is drawn while it is not known where odom is on the map", () => {
  const message = { type: "landmarks" as const, landmarks: [{ text: "door", x: 1, y: 2 } as Landmark] };
  const draw = (context: Context, onScreen: OnScreen) => landmarksLayer.draw(context, message, onScreen);
  expect(placesOf(draw)).toHaveLength(1);
  expect(placesOf(draw, false)).toEqual([]);
  message.landmarks.push({ text: "desk", x: 3, y: 4, frame: "map" } as Landmark);
  expect(placesOf(draw, false)).toHaveLength(1);
});

test("persons are drawn with their numbers, who speaks is said, and what may be a chair is left out", () => {
  const persons = [
    { person: 3, state: "confirmed", p_OP: [1, 2, 1.6], speaking: true },
    { person: null, state: "unsure", p_OP: [2, 2, 1.6], speaking: false },
    { person: null, state: "tentative", p_OP: [3, 2, 1.6], speaking: false },
  ];
  const message = { type: "persons", stamp: 1, persons } as unknown as Message<"persons">;
  const written: unknown[] = [];
  const context = new Proxy({} as Record<string, unknown>, {
    get: (_, name) => (text: unknown, x: number, y: number) => {
      if (name === "fillText") written.push([text, x, y]);
    },
    set: () => true,
  });
  personsLayer.draw(context as unknown as Context, message, ({ x, y }) => ({ x: 10 * x, y: 10 * y }));
  expect(written).toEqual([
    ["Person 3, speaking", 10, 11],
    ["Person ?", 20, 11],
  ]);
});
