import { signal } from "@preact/signals";
import { h } from "preact";
import { expect, test, vi } from "vitest";
import type { Landmark, Tour } from "../protocol/types";
import type { Message } from "../state/latest";
import { createStore } from "../state/store";
import { aStop, aTour } from "../tours/tours.fixture";
import { drawn } from "../ui/page.fixture";
import { foundPanel } from "./Found";

const ARM = { text: "tour:arm", id: 7, x: 3, y: 0, z: 1.2, sigma_m: 0.03, sightings: 3, frame: "map" } as Landmark;
const FOUND = { type: "landmarks", landmarks: [ARM] } as Message<"landmarks">;

function shown({ lack = "", tour = aTour([]) as Tour | null } = {}) {
  const stops = { lack: () => lack, fromPoster: vi.fn() };
  const places = { all: signal([]), kept: signal(true), busy: signal(false), addBefore: vi.fn() };
  const map = { allowed: signal(true) };
  const app = { store: createStore(), stops, places, map, tours: { draft: signal(tour) } };
  return { stops, places, page: drawn(h(foundPanel.Card, { message: FOUND }), app) };
}

test("a poster that was found becomes a stop of the tour that is edited", async () => {
  const { page, stops } = shown();
  await page.press("landmark-stop");
  expect(stops.fromPoster.mock.calls).toEqual([[ARM]]);
});

test("why no stop can be made before it is said by the button, which does nothing", () => {
  const { attributes } = shown({ lack: "Which way it faces is not known yet." }).page.one("landmark-stop");
  expect([attributes.get("disabled"), attributes.get("title")]).toEqual([true, "Which way it faces is not known yet."]);
});

test.each([
  ["no tour is edited", null],
  ["it is a stop already", aTour([aStop("arm", { poster: "tour:arm" })])],
])("where %s it is offered as a place alone", async (_, tour) => {
  const { page, places } = shown({ tour });
  expect(page.all("landmark-stop")).toEqual([]);
  await page.press("landmark-place");
  expect(places.addBefore.mock.calls).toEqual([[ARM]]);
});
