import { expect, test } from "vitest";
import { NO_STEP } from "./tourEdits";
import { withPoint } from "./tourPath";
import { aStop, aTour } from "./tours.fixture";

test("a click sets where a step points, as high as it was", () => {
  const tour = aTour([aStop("a"), aStop("b", { do: [NO_STEP, { ...NO_STEP, point: [0, 0, 1.6] }] })]);
  const pointed = withPoint(tour, { path: "stops.1.do.1", part: "point" }, [3, 4]);
  expect(pointed.stops[1]?.do[1]?.point).toEqual([3, 4, 1.6]);
  expect(pointed.stops[0]).toBe(tour.stops[0]);
  expect(tour.stops[1]?.do[1]?.point).toEqual([0, 0, 1.6]);
});

test("a point that was measured has a height of its own", () => {
  const tour = aTour([aStop("a", { do: [{ ...NO_STEP, point: [0, 0, 1.6] }] })]);
  const pointed = withPoint(tour, { path: "stops.0.do.0", part: "point" }, [3, 4, 0.8]);
  expect(pointed.stops[0]?.do[0]?.point).toEqual([3, 4, 0.8]);
});

test("what had no point gets one at the height of eyes", () => {
  const tour = aTour([], { greeting: { do: [{ ...NO_STEP, look: "visitors" }], confirm: null } });
  const looked = withPoint(tour, { path: "greeting.do.0", part: "look" }, [3, 4]);
  expect(looked.greeting.do[0]?.look).toEqual([3, 4, 1.2]);
});
