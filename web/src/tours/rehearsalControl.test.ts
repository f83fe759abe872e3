import { signal } from "@preact/signals";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { TourRest } from "../protocol/tourRest";
import { createStore } from "../state/store";
import { RehearsalControl } from "./rehearsalControl";
import { TourControl } from "./tourControl";
import { aRehearsal, aRehearsalReport } from "./tourRun.fixture";
import { aStop, aTour } from "./tours.fixture";

function page() {
  const asked = {
    rehearse: vi.fn(async () => aRehearsalReport()),
    rehearsal: vi.fn(async () => aRehearsalReport({ seconds: 10 })),
    cancelRehearsal: vi.fn(async () => undefined),
  };
  const rest = asked as unknown as TourRest;
  const tours = new TourControl(createStore(), rest, signal(true));
  tours.draft.value = aTour([aStop("arm")]);
  tours.kept.value = {
    tour: tours.draft.value as never,
    shipped: false,
    can_undo: false,
    can_redo: false,
    problems: [],
    etag: "",
  };
  const control = new RehearsalControl(rest, tours);
  control.start();
  return { asked, control, tours };
}

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

test("a rehearsal is followed to its end, then played on the map", async () => {
  const { asked, control } = page();
  await control.begin("fr");
  expect(asked.rehearse).toHaveBeenCalledWith("lab", { language: "fr" });
  await vi.advanceTimersByTimeAsync(500);
  expect(control.report.value?.seconds).toBe(10);
  const path = [0, 50, 104.5].map((at_s) => ({ at_s, x: at_s, y: 0, heading: 0, farthest_m: null }));
  asked.rehearsal.mockResolvedValue(aRehearsalReport({ state: "done", result: aRehearsal({ path }) }));
  await vi.advanceTimersByTimeAsync(500);
  expect(control.playing.value).toBe(true);
  const calls = asked.rehearsal.mock.calls.length;
  await vi.advanceTimersByTimeAsync(1000);
  expect(control.mark.value?.x).toBeGreaterThanOrEqual(10); // ten seconds in one
  await vi.advanceTimersByTimeAsync(60_000);
  expect([control.at.value, control.playing.value]).toEqual([104.5, false]);
  expect(asked.rehearsal.mock.calls.length).toBe(calls); // it is over
  control.play();
  expect([control.at.value, control.playing.value]).toEqual([0, true]);
});

test("of another tour nothing is shown", async () => {
  const { control, tours } = page();
  control.report.value = aRehearsalReport({ state: "done", result: aRehearsal() });
  expect(control.result.value).not.toBeNull();
  tours.draft.value = aTour([], { id: "other" });
  expect(control.result.value).toBeNull();
  expect(control.mark.value).toBeNull();
});

test("a refusal stays in words; one that runs is asked for again", async () => {
  const { asked, control } = page();
  asked.rehearse.mockRejectedValueOnce(new Problem(409, "Busy", "Other is being rehearsed already."));
  await control.begin("en");
  expect(control.refusal.value).toBe("Other is being rehearsed already.");
  await control.begin("en");
  asked.rehearsal.mockRejectedValueOnce(new Problem(0, "No answer", "The robot did not answer."));
  await vi.advanceTimersByTimeAsync(500);
  expect(control.refusal.value).toBe("The robot did not answer.");
  await vi.advanceTimersByTimeAsync(500);
  expect(control.refusal.value).toBe("");
  await control.cancel();
  expect(control.report.value).toBeNull();
});
