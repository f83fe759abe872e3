import { signal } from "@preact/signals";
import { expect, test, vi } from "vitest";
import { PlaceControl } from "../map/placeControl";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { TourRest } from "../protocol/tourRest";
import type { Landmark, NewPlace, Place, Tour } from "../protocol/types";
import { createStore } from "../state/store";
import { StopMaker } from "./stopMaker";
import { TourControl } from "./tourControl";
import { aStop, aTour } from "./tours.fixture";

const poster = (text: string, x: number, more: Partial<Landmark> = {}): Landmark => ({
  text,
  id: 7,
  x,
  y: 0,
  z: 1.25,
  sigma_m: 0.03,
  sightings: 3,
  first_seen: 0,
  last_seen: 1,
  heading: 0,
  heading_sigma: 0.1,
  frame: "map",
  ...more,
});
const ARM = poster("HBBA:STOP/ARM", 3);

async function opened(refusal: Problem | null = null) {
  let tour: Tour = aTour([aStop("desk", { poster: "tour:desk" })]);
  let version = 1;
  const kept = () => ({ tour: tour as unknown as Record<string, unknown>, etag: `${version}`, problems: [] });
  const addPlace = vi.fn(async (wanted: NewPlace): Promise<Place> => {
    if (refusal) throw refusal;
    const { name, poster: of } = { name: "", ...wanted };
    const source = of ? "poster" : "here";
    const place = { id: "made", name: name ?? "", x: 0, y: 0, heading: 0, landmark: 7, problem: "", etag: "" };
    return { ...place, source, poster: of?.text ?? "" };
  });
  const rest = {
    addPlace,
    tour: async () => kept(),
    replaceTour: async (_: string, sent: Tour) => {
      tour = sent;
      version++;
      return kept();
    },
  } as unknown as Rest & TourRest;
  const store = createStore();
  const tours = new TourControl(store, rest, signal(true));
  await tours.open("lab");
  const stops = new StopMaker(store, rest, new PlaceControl(store, rest), tours);
  return { addPlace, stops, store, tours, last: () => tour.stops.at(-1) };
}

test("a point of the floor becomes a place with a heading and a stop there", async () => {
  const { addPlace, last, stops } = await opened();
  await stops.on({ x: 1.5, y: -2 }, 0.5);
  expect(addPlace).toHaveBeenCalledWith({ pose: { x: 1.5, y: -2, heading: 0.5 }, name: "Stop 2" });
  expect(last()).toMatchObject({ place: "made", poster: null, title: { en: "Stop 2" } });
});

test("a poster becomes a place and a stop before it, which opens", async () => {
  const { addPlace, last, stops } = await opened();
  await stops.fromPoster(ARM);
  expect(addPlace).toHaveBeenCalledWith({ poster: { text: "HBBA:STOP/ARM", near: [3, 0] }, name: "Arm" });
  expect(last()).toMatchObject({ id: "arm", place: "made", poster: "HBBA:STOP/ARM", title: { en: "Arm" } });
  expect(stops.open.value).toBe("arm");
});

test("a place that is before the poster already is taken", async () => {
  const { addPlace, last, stops, store } = await opened();
  const place: Place = { ...(await addPlace({ poster: { text: ARM.text } })), id: "there" };
  addPlace.mockClear();
  store.latest.put({ type: "places", places: [place] });
  await stops.fromPoster(ARM);
  expect([addPlace.mock.calls.length, last()?.place]).toEqual([0, "there"]);
});

test("the robot's own place becomes a stop with a name that no place has", async () => {
  const { addPlace, last, stops, store } = await opened();
  const taken = { ...(await addPlace({ name: "Stop 2" })), name: "Stop 2" };
  store.latest.put({ type: "places", places: [taken] });
  await stops.here();
  expect(addPlace).toHaveBeenLastCalledWith({ here: true, name: "Stop 2 2" });
  expect(last()).toMatchObject({ place: "made", poster: null });
});

test("without a place there is no stop, and the reason is shown", async () => {
  const { last, stops, store } = await opened(new Problem(409, "Unknown", "Where the robot is is not known."));
  await stops.here();
  expect(last()?.id).toBe("desk");
  expect(store.notices.value[0]?.text).toContain("not known");
});

test("why no stop is made before a poster", async () => {
  const { stops, tours } = await opened();
  expect(stops.lack(ARM)).toBe("");
  expect(stops.lack(poster("tour:desk", 1))).toContain("already");
  expect(stops.lack({ ...ARM, heading: null })).toContain("Which way it faces");
  tours.close();
  expect(stops.lack(ARM)).toBe("No tour is open.");
});

test("a click on the map takes the nearest poster within reach of a finger", async () => {
  const { stops, store, tours } = await opened();
  store.latest.put({ type: "landmarks", landmarks: [ARM, poster("b", 3.2), poster("c", 3, { frame: "odom" })] });
  expect(stops.pick({ x: 3.15, y: 0 }, 50)).toBe(true);
  expect(stops.picked.value?.text).toBe("b");
  expect(stops.pick({ x: 5, y: 0 }, 50)).toBe(false);
  expect(stops.picked.value).toBeNull();
  tours.close();
  expect(stops.pick({ x: 3, y: 0 }, 50)).toBe(false);
});
