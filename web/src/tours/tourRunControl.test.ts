import { signal } from "@preact/signals";
import { expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { TourRest } from "../protocol/tourRest";
import type { Tour, TourProgress } from "../protocol/types";
import { createStore } from "../state/store";
import { TourControl } from "./tourControl";
import { aProgress, aReport } from "./tourRun.fixture";
import { TourRunControl } from "./tourRunControl";
import { aStop, aTour } from "./tours.fixture";

/** A page on a robot that keeps the tours "broken" (which cannot run) and "lab". */
async function page() {
  const asked = {
    tours: async () => ({
      folder: "",
      tours: [
        { id: "broken", languages: ["en"], errors: 1, problem: null },
        { id: "lab", languages: ["fr", "en"], errors: 0, problem: null },
        { id: "damaged", languages: [], errors: 0, problem: "it cannot be read" },
      ],
    }),
    tour: async () => ({ tour: aTour([aStop("door"), aStop("gone", { left_out: true }), aStop("arm")]), etag: "1" }),
    startTour: vi.fn(async () => ({})),
    pressTour: vi.fn(async () => ({})),
    dismissTour: vi.fn(async () => undefined),
    tourReports: vi.fn(async () => [aReport()]),
    deleteTourReport: vi.fn(async () => undefined),
  };
  const rest = asked as unknown as TourRest;
  const store = createStore();
  store.link.value = { phase: "live", retryAt: 0 };
  const tours = new TourControl(store, rest, signal(true));
  const run = new TourRunControl(store, rest, tours);
  await tours.refresh();
  run.start();
  const goes = (progress: TourProgress) => store.latest.put({ type: "tour", ...progress });
  return { asked, goes, run, store, tours };
}

test("the first tour that can run is offered, in its first language; another can be chosen", async () => {
  const { asked, run, tours } = await page();
  expect(run.chosen.value?.id).toBe("lab");
  await run.begin("now");
  expect(asked.startTour).toHaveBeenLastCalledWith("lab", { begin: "now", language: "fr" });
  run.language.value = "en";
  await run.begin("visitors");
  expect(asked.startTour).toHaveBeenLastCalledWith("lab", { begin: "visitors", language: "en" });
  tours.draft.value = aTour([], { id: "broken" }) as Tour;
  expect(run.chosen.value?.id).toBe("broken"); // the one that is edited
  run.wanted.value = "lab";
  expect(run.chosen.value?.id).toBe("lab");
  run.wanted.value = "damaged";
  expect(run.chosen.value?.id).toBe("broken");
});

test("a language that the chosen tour does not have is not asked for", async () => {
  const { asked, run } = await page();
  run.language.value = "de";
  await run.begin("now");
  expect(asked.startTour).toHaveBeenLastCalledWith("lab", { begin: "now", language: "fr" });
});

test("what is refused stays in words until a press is taken", async () => {
  const { asked, run } = await page();
  asked.pressTour.mockRejectedValueOnce(new Problem(409, "Refused", "Next does nothing while the tour is paused."));
  await run.press({ button: "next" });
  expect(run.refusal.value).toBe("Next does nothing while the tour is paused.");
  expect(run.busy.value).toBe(false);
  await run.press({ button: "resume" });
  expect(run.refusal.value).toBe("");
});

test("the stops to go to are those of the tour under way that are not left out", async () => {
  const { goes, run } = await page();
  goes(aProgress());
  await vi.waitFor(() => expect(run.stops.value.map(({ id }) => id)).toEqual(["door", "arm"]));
  goes(aProgress({ tour: "", state: "idle" }));
  expect(run.progress.value).toBeNull();
  expect(run.stops.value).toEqual([]);
});

test("reports are read again when a tour has ended, and when one was deleted", async () => {
  const { asked, goes, run } = await page();
  await vi.waitFor(() => expect(run.reports.value).toHaveLength(1));
  goes(aProgress());
  expect(asked.tourReports).toHaveBeenCalledTimes(1);
  goes(aProgress({ state: "idle" }));
  expect(asked.tourReports).toHaveBeenCalledTimes(2);
  await run.deleteReport("a");
  expect(asked.deleteTourReport).toHaveBeenCalledWith("a");
  expect(asked.tourReports).toHaveBeenCalledTimes(3);
});
