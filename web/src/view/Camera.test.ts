import { signal } from "@preact/signals";
import { h } from "preact";
import { act } from "preact/test-utils";
import { expect, test, vi } from "vitest";
import { createStore } from "../state/store";
import type { PointTarget } from "../tours/tourPath";
import { drawn } from "../ui/page.fixture";
import { Camera } from "./Camera";

const TARGET: PointTarget = { path: "stops.0.do.0", part: "point" };

function shown(target: PointTarget | null) {
  const store = createStore();
  store.link.value = { phase: "live", retryAt: 0 };
  store.now.value = 10.6;
  const camera = {
    stamp: signal(10.5),
    size: { width: 640, height: 480 },
    coding: signal("jpeg"),
    show: () => undefined,
  };
  const tourPointing = { target: signal(target), picture: vi.fn() };
  const drive = { lookHere: vi.fn() };
  const page = drawn(h(Camera, null), { store, camera, tourPointing, drive, map: {}, session: {} });
  const [canvas] = page.one("camera").all();
  Object.assign(canvas!, { getBoundingClientRect: () => ({ left: 100, top: 50, width: 800, height: 480 }) });
  return { camera, store, page, drive, tourPointing, click: (at: object) => page.fire(canvas!, "click", at) };
}

test("a click in the picture is the point that is waited for, as shares of the picture that is shown", async () => {
  const { click, drive, tourPointing } = shown(TARGET);
  await click({ clientX: 100 + 80 + 160, clientY: 50 + 360 }); // the picture has 80 px of nothing at each side
  expect(tourPointing.picture.mock.calls).toEqual([[10.5, 0.25, 0.75]]);
  await click({ clientX: 140, clientY: 50 + 360 });
  expect(tourPointing.picture).toHaveBeenCalledTimes(1);
  expect(drive.lookHere).not.toHaveBeenCalled();
});

test("with Shift too, while a point is waited for", async () => {
  const { click, tourPointing } = shown(TARGET);
  await click({ clientX: 500, clientY: 290, shiftKey: true });
  expect(tourPointing.picture.mock.calls).toEqual([[10.5, 0.5, 0.5]]);
});

test("else the head turns there", async () => {
  const { click, drive, tourPointing } = shown(null);
  await click({ clientX: 500, clientY: 290 });
  expect(drive.lookHere.mock.calls).toEqual([[10.5, 0.5, 0.5]]);
  expect(tourPointing.picture).not.toHaveBeenCalled();
});

test("in a recording that is paused, the age is that of the picture that has come last", async () => {
  const { camera, page, store } = shown(null);
  await act(() => {
    store.playback.value = {} as typeof store.playback.value;
    store.now.value = 31;
  });
  expect(page.one("camera-age").textContent).toBe("20.5 s old");
  await act(() => void (camera.stamp.value = 30.9));
  expect(page.all("camera-age")).toEqual([]);
});
