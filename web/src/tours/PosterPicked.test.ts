import { signal } from "@preact/signals";
import { h } from "preact";
import { expect, test, vi } from "vitest";
import type { Landmark } from "../protocol/types";
import { drawn } from "../ui/page.fixture";
import { PosterPicked } from "./PosterPicked";
import { aTour } from "./tours.fixture";

const ARM = { text: "tour:arm", id: 7, x: 3, y: 0, frame: "map" } as Landmark;

function shown({ lack = "", allowed = true } = {}) {
  const stops = { picked: signal<Landmark | null>(ARM), lack: () => lack, fromPoster: vi.fn() };
  const tours = { draft: signal(aTour([])), allowed: signal(allowed) };
  return { stops, page: drawn(h(PosterPicked, null), { stops, tours }) };
}

test("a poster that was clicked on the map becomes a stop", async () => {
  const { page, stops } = shown();
  expect(page.one("poster-picked").attributes.get("data-text")).toBe("tour:arm");
  await page.press("poster-stop");
  expect(stops.fromPoster.mock.calls).toEqual([[ARM]]);
});

test("why none can be made before it is said, and the button does nothing", () => {
  const { page } = shown({ lack: "It is a stop of this tour already." });
  expect(page.words()).toContain("It is a stop of this tour already.");
  expect(page.one("poster-stop").attributes.get("disabled")).toBe(true);
  expect(shown({ allowed: false }).page.one("poster-stop").attributes.get("disabled")).toBe(true);
});
