import { signal } from "@preact/signals";
import { expect, test, vi } from "vitest";
import type { MapLibrary } from "../map/library";
import type { MapControl } from "../map/mapControl";
import { PlaceControl } from "../map/placeControl";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { TourRest } from "../protocol/tourRest";
import type { Landmark, NewPlace } from "../protocol/types";
import { createStore } from "../state/store";
import { TourControl } from "./tourControl";
import { TourDrive } from "./tourDrive";
import type { NewTour } from "./tourEdits";

const poster = (id: number, text: string, sightings = 1): Landmark => ({
  text,
  id,
  x: id,
  y: 0,
  z: 1.25,
  sigma_m: 0.03,
  sightings,
  first_seen: 0,
  last_seen: id,
  heading: 0,
  heading_sigma: 0.1,
  frame: "map",
});

/** A page on a robot whose map in use has the name `map`, and which keeps a map "lab". */
function driving(map: string) {
  const kept = new Map<string, string>();
  vi.stubGlobal("localStorage", {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => kept.set(key, value),
    removeItem: (key: string) => kept.delete(key),
  });
  const made: NewTour[] = [];
  const asked = {
    saveMap: vi.fn(async () => undefined),
    maps: async () => ({ maps: [{ name: "lab" }] }),
    tours: async () => ({ folder: "", tours: [{ id: "the-lab", etag: "1" }] }),
    addPlace: vi.fn(async ({ name, poster: of }: NewPlace) => {
      if (of?.text === "tour:far") throw new Problem(409, "Unknown", "Which way it faces is not known.");
      return { id: `before-${name}`.toLowerCase(), name };
    }),
    createTour: async (tour: NewTour) => {
      made.push(tour);
      return { tour, etag: "2", problems: [] };
    },
    addDesire: vi.fn(async () => ({})),
  };
  const rest = asked as unknown as Rest & TourRest;
  const store = createStore();
  const maps = { inUse: signal(map), refresh: async () => undefined } as unknown as MapLibrary;
  const control = { desireMap: vi.fn(async () => undefined) } as unknown as MapControl;
  const tours = new TourControl(store, rest, signal(true));
  const open = () => {
    const page = new TourDrive(store, rest, control, maps, new PlaceControl(store, rest), tours);
    page.start();
    return page;
  };
  const see = (...landmarks: Landmark[]) => store.latest.put({ type: "landmarks", landmarks });
  return { asked, made, open, see, store };
}

test("posters met on the way become a tour, with the map and a place before each", async () => {
  const { asked, made, open, see } = driving("");
  const page = open();
  await page.begin("The lab", "en");
  see(poster(2, "tour:door"));
  see(poster(2, "tour:door", 3), poster(1, "HBBA:STOP/ARM"));
  await page.finish("ground");
  expect(asked.saveMap).toHaveBeenCalledWith("ground");
  expect(made).toMatchObject([
    {
      id: "the-lab-2",
      map: "ground",
      stops: [
        { id: "door", place: "before-door", poster: "tour:door" },
        { id: "arm", place: "before-arm", poster: "HBBA:STOP/ARM" },
      ],
    },
  ]);
  expect([page.tour.value, page.problem.value]).toEqual([null, ""]);
});

test("a map of others is not replaced", async () => {
  const { asked, open, see } = driving("");
  const page = open();
  await page.begin("The lab", "en");
  see(poster(2, "tour:door"));
  await page.finish("lab");
  expect(page.problem.value).toContain("There is a map lab already");
  expect([asked.saveMap.mock.calls.length, page.tour.value?.met.length]).toEqual([0, 1]);
});

test("a poster before which no place can be is no stop, and it is said why", async () => {
  const { made, open, see, store } = driving("ground");
  const page = open();
  await page.begin("The lab", "en");
  see(poster(2, "tour:door"), poster(3, "tour:far"));
  await page.finish("");
  expect(made[0]?.stops.map(({ id }) => id)).toEqual(["door"]);
  expect(store.notices.value.some(({ text }) => text.includes("Far is no stop: Which way"))).toBe(true);
});

test("what was met outlasts the page", async () => {
  const { open, see } = driving("ground");
  const page = open();
  await page.begin("The lab", "en");
  see(poster(2, "tour:door"));
  expect(open().tour.value).toMatchObject({ title: "The lab", met: [{ text: "tour:door" }] });
  page.discard();
  expect(open().tour.value).toBeNull();
});
