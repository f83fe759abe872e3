import { signal } from "@preact/signals";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Place, RouteReport, Tour } from "../protocol/types";
import { RouteControl } from "./routeControl";
import { aStop, aTour } from "./tours.fixture";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const place = (id: string, x: number): Place => ({
  id,
  name: id,
  x,
  y: 0,
  heading: 0,
  source: "hand",
  poster: "",
  landmark: 0,
  problem: "",
  etag: "",
});

/** A control whose requests are answered one by one. */
function planned() {
  const answers: { resolve: (route: RouteReport) => void; reject: (error: Problem) => void }[] = [];
  const rest = {
    planRoute: () => new Promise<RouteReport>((resolve, reject) => void answers.push({ resolve, reject })),
  };
  const draft = signal<Tour | null>(aTour([aStop("a"), aStop("b")]));
  const places = signal([place("a", 1), place("b", 2)]);
  const map = signal("ground");
  const sources = { draft, places, zones: signal([]), map, able: signal(true) };
  const control = new RouteControl(rest as unknown as Rest, sources);
  control.start();
  return { control, places, answers };
}

const A_ROUTE = { legs: [] } as unknown as RouteReport;

test("a slow robot is asked for one route at a time, and then for the newest alone", async () => {
  const { places, answers } = planned();
  await vi.advanceTimersByTimeAsync(1000);
  expect(answers).toHaveLength(1);
  for (const x of [3, 4, 5]) {
    places.value = [place("a", x), place("b", 2)];
    await vi.advanceTimersByTimeAsync(1000);
  }
  expect(answers).toHaveLength(1);
  answers[0]!.resolve(A_ROUTE);
  await vi.advanceTimersByTimeAsync(0);
  expect(answers).toHaveLength(2);
});

test("a robot that plans for others is asked again, and nothing is missing meanwhile", async () => {
  const { control, answers } = planned();
  await vi.advanceTimersByTimeAsync(1000);
  answers[0]!.reject(new Problem(409, "Busy", "4 routes wait to be planned already: try again."));
  await vi.advanceTimersByTimeAsync(0);
  expect(control.lack.value).toBe("");
  await vi.advanceTimersByTimeAsync(5000);
  expect(answers).toHaveLength(2);
  answers[1]!.reject(new Problem(409, "No map", "There is no map."));
  await vi.advanceTimersByTimeAsync(5000);
  expect(control.lack.value).toBe("There is no map.");
  expect(answers).toHaveLength(2);
});
