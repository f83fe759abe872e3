import { signal } from "@preact/signals";
import { h } from "preact";
import { expect, test, vi } from "vitest";
import type { NewDesire, Place, Step, Tour, TourProblemReport } from "../protocol/types";
import { createStore } from "../state/store";
import { drawn } from "../ui/page.fixture";
import { StopForm } from "./StopForm";
import { NO_STEP } from "./tourEdits";
import { aStop, aTour } from "./tours.fixture";
import { TourTrial } from "./tourTrial";

const WAVE: Step = { ...NO_STEP, say: { en: "Hello." }, gesture: { class: "Wave", params: { times: 2 } } };

function shown({ step = WAVE, live = true, goes = true, place = "before the arm" } = {}) {
  const store = createStore();
  store.link.value = { phase: live ? "live" : "lost", retryAt: 0 };
  const classes = ["Say", "Wave", ...(goes ? ["GoTo"] : [])].map((name) => ({ name, served: true, schema: {} }));
  store.hello.value = { classes, robot: { limits: {} }, channels: {} } as unknown as typeof store.hello.value;
  const desires: NewDesire[] = [];
  const rest = { addDesire: async (desire: NewDesire) => void desires.push(desire) };
  const stop = aStop("arm", { place: "before the arm", do: [step] });
  const draft = signal<Tour>(aTour([stop], { languages: ["en"] }));
  const edit = vi.fn(async (change: (tour: Tour) => Tour) => void (draft.value = change(draft.peek())));
  const map = { allowed: signal(live), goToPlace: vi.fn() };
  const tourPointing = { choose: vi.fn(), isFor: () => false, target: signal(null) };
  const app = {
    store,
    map,
    tourPointing,
    tours: { draft, edit, problems: signal<TourProblemReport[]>([]), media: { files: signal([]) } },
    places: { all: signal([{ id: place, name: "Before the arm" } as Place]) },
    session: { rest: { posters: () => "" } },
    stops: { open: signal("arm") },
    tourTrial: new TourTrial(store, rest as unknown as ConstructorParameters<typeof TourTrial>[1]),
  };
  return { desires, draft, map, tourPointing, page: drawn(h(StopForm, { stop, number: 0 }), app) };
}

test("Try has the robot do the step now", async () => {
  const { desires, page } = shown();
  await page.press("step-try");
  expect(desires.map(({ class: kind, params }) => [kind, params])).toEqual([
    ["Say", { text: "Hello.", language: "en" }],
    ["Wave", { times: 2 }],
  ]);
});

test.each([
  ["nothing is heard of the robot", { live: false }],
  ["the robot does nothing for it", { step: { ...NO_STEP, expression: "happy" } as Step }],
])("Try does nothing while %s", (_, parts) => {
  expect(shown(parts).page.one("step-try").attributes.get("disabled")).toBe(true);
});

test("Drive there has the robot go to the stop's place", async () => {
  const { map, page } = shown();
  await page.press("stop-go");
  expect(map.goToPlace.mock.calls).toEqual([["before the arm"]]);
});

test("Drive there does nothing for a place of another map, and without the robot", () => {
  expect(shown({ place: "elsewhere" }).page.one("stop-go").attributes.get("disabled")).toBe(true);
  expect(shown({ live: false }).page.one("stop-go").attributes.get("disabled")).toBe(true);
});

test("a robot that goes nowhere has no such button", () => {
  expect(shown({ goes: false }).page.all("stop-go")).toEqual([]);
});

test("a point is added to a step by a click that is waited for, and its button says so in words", async () => {
  const { draft, page, tourPointing } = shown();
  expect(page.one("step-add-point").textContent).toBe("+ Point");
  await page.press("step-add-point");
  expect(draft.value.stops[0]!.do[0]!.point).toEqual([0, 0, expect.any(Number)]);
  expect(tourPointing.choose.mock.calls).toEqual([[{ path: "stops.0.do.0", part: "point" }]]);
});
