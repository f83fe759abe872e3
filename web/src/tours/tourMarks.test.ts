import { expect, test } from "vitest";
import type { Place } from "../protocol/types";
import { gaps } from "./tourMarks";
import type { Leg } from "./tourRoute";
import { aStop, aTour } from "./tours.fixture";

const place = (id: string) => ({ id }) as Place;
const leg = (stop: string | null, state: Leg["state"]): Leg => ({
  stop,
  state,
  reason: "",
  length_m: 0,
  duration_s: 0,
  path: [],
});
const PLACED = new Map(["a", "b", "dock"].map((id) => [id, place(id)]));
const ends = (found: [Place, Place][]) => found.map(([from, to]) => `${from.id} ${to.id}`);

test("a leg that cannot be driven joins the places that it is between", () => {
  const tour = aTour([aStop("a"), aStop("b")], { home: "dock" });
  expect(ends(gaps(tour, [leg("a", "none"), leg("b", "way"), leg(null, "none")], PLACED))).toEqual([
    "dock a",
    "b dock",
  ]);
});

test("without a home the first stop is where the way begins", () => {
  const tour = aTour([aStop("a"), aStop("gone"), aStop("b")]);
  expect(ends(gaps(tour, [leg("gone", "none"), leg("b", "none")], PLACED))).toEqual(["a b"]);
});
