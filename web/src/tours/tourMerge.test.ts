import { expect, test } from "vitest";
import { stopChanged, stopMoved, withoutStop, withStop } from "./tourEdits";
import { equal, merge } from "./tourMerge";
import { aStop, aTour } from "./tours.fixture";

const BASE = aTour([aStop("a"), aStop("b"), aStop("c")]);
const ids = (tour: typeof BASE) => tour.stops.map(({ id }) => id).join(" ");

test("what only one has changed is kept", () => {
  const mine = stopChanged(BASE, "a", { place: "window" });
  const theirs = { ...stopChanged(BASE, "c", { left_out: true }), title: { en: "Our lab" } };
  const { merged, conflicts } = merge(BASE, mine, theirs);
  expect(conflicts).toEqual([]);
  expect(merged).toEqual({ ...stopChanged(theirs, "a", { place: "window" }) });
});

test("two changes within one text of two languages go together", () => {
  const mine = { ...BASE, title: { en: "The lab", fr: "Le labo" } };
  const theirs = { ...BASE, title: { en: "Our lab" } };
  expect(merge(BASE, mine, theirs)).toEqual({
    merged: { ...BASE, title: { en: "Our lab", fr: "Le labo" } },
    conflicts: [],
  });
});

test("what both have changed differently is a conflict, and mine until people decide", () => {
  const { merged, conflicts } = merge(
    BASE,
    stopChanged(BASE, "b", { title: { en: "Mine" } }),
    stopChanged(BASE, "b", { title: { en: "Theirs" }, place: "door" }),
  );
  expect(conflicts).toEqual(["stops.b.title.en"]);
  expect(merged.stops[1]).toMatchObject({ title: { en: "Mine" }, place: "door" });
});

test("the same change of both is none to decide on", () => {
  const same = stopChanged(BASE, "b", { place: "door" });
  expect(merge(BASE, same, { ...same, home: "dock" })).toEqual({ merged: { ...same, home: "dock" }, conflicts: [] });
});

test("a stop that one adds and the order that the other gives go together", () => {
  const mine = stopMoved(BASE, "c", 0);
  const theirs = withStop(BASE, aStop("d"), 2);
  const { merged, conflicts } = merge(BASE, mine, theirs);
  expect([ids(merged), conflicts]).toEqual(["c a b d", []]);
  expect(ids(merge(BASE, theirs, mine).merged)).toBe("c a b d");
});

test("both add a stop at the end", () => {
  const { merged } = merge(BASE, withStop(BASE, aStop("mine")), withStop(BASE, aStop("theirs")));
  expect(merged.stops.map(({ id }) => id).toSorted()).toEqual(["a", "b", "c", "mine", "theirs"]);
});

test("a stop that one deletes is gone, unless the other has changed it", () => {
  expect(ids(merge(BASE, withoutStop(BASE, "b"), { ...BASE, home: "dock" }).merged)).toBe("a c");
  expect(ids(merge(BASE, { ...BASE, home: "dock" }, withoutStop(BASE, "b")).merged)).toBe("a c");
  const { merged, conflicts } = merge(BASE, withoutStop(BASE, "b"), stopChanged(BASE, "b", { place: "door" }));
  expect([merged.stops.find(({ id }) => id === "b")?.place, conflicts]).toEqual(["door", ["stops.b"]]);
});

test("lists without ids are one value where they differ in length", () => {
  const languages = (...all: string[]) => ({ ...BASE, languages: all });
  expect(merge(BASE, languages("en"), languages("en", "fr", "de")).conflicts).toEqual(["languages"]);
  expect(merge(BASE, languages("en"), BASE).merged.languages).toEqual(["en"]);
});

test("values are compared by what they are", () => {
  expect(equal({ a: [1, { b: null }] }, { a: [1, { b: null }] })).toBe(true);
  expect(equal({ a: undefined }, {})).toBe(false);
  expect(equal([1], { 0: 1 })).toBe(false);
});
