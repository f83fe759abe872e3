import { signal } from "@preact/signals";
import { h } from "preact";
import { expect, test, vi } from "vitest";
import type { Landmark, Perceived, Tour } from "../protocol/types";
import { createStore } from "../state/store";
import { aTour } from "../tours/tours.fixture";
import { drawn } from "../ui/page.fixture";
import { FaceFrames } from "./FaceFrames";

const ARM = { text: "tour:arm", id: 7, x: 3, y: 0, frame: "map" } as Landmark;
const SEEN = {
  faces: [],
  codes: [
    {
      text: "tour:arm",
      camera: "kinect_optical_frame",
      stamp: 10,
      image: [640, 480],
      corners: [
        [160, 120],
        [320, 120],
        [320, 240],
        [160, 240],
      ],
    },
  ],
} as unknown as Perceived;

function shown({ lack = "", tour = aTour([]) as Tour | null, found = [ARM] } = {}) {
  const store = createStore();
  store.latest.put({ type: "landmarks", landmarks: found });
  const stops = { lack: () => lack, fromPoster: vi.fn() };
  const app = { store, stops, tours: { draft: signal(tour) }, camera: { stamp: signal(10) } };
  return { stops, page: drawn(h(FaceFrames, { message: SEEN }), app) };
}

test("a poster in the camera's picture becomes a stop of the tour that is edited", async () => {
  const { page, stops } = shown();
  expect(page.one("code-frame").attributes.get("data-text")).toBe("tour:arm");
  await page.press("code-stop");
  expect(stops.fromPoster.mock.calls).toEqual([[ARM]]);
});

test.each([
  ["no tour is edited", { tour: null }],
  ["it is on no map yet", { found: [] }],
  ["no stop can be made before it", { lack: "It is a stop of this tour already." }],
])("the frame has no button where %s", (_, parts) => {
  const { page } = shown(parts);
  expect([page.all("code-frame").length, page.all("code-stop").length]).toEqual([1, 0]);
});
