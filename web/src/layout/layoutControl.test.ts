import { expect, test } from "vitest";
import { createStore } from "../state/store";
import { DEFAULTS } from "./layout";
import { LayoutControl } from "./layoutControl";

function shelf() {
  const kept = new Map<string, string>();
  return {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, text: string) => void kept.set(key, text),
  };
}

test("a preset opens its tab, and the tour's the map over the view", () => {
  const store = createStore();
  const control = new LayoutControl(store, shelf());
  control.choose("debug");
  expect([store.tab.value, store.mapPlace.value]).toEqual(["load", "tab"]);
  control.choose("tour");
  expect([store.tab.value, store.mapPlace.value]).toEqual(["tour", "view"]);
  control.choose("attention");
  expect([store.tab.value, store.mapPlace.value]).toEqual(["attention", "tab"]);
});

test("each preset keeps its own changes, over a reload too", () => {
  const storage = shelf();
  const before = new LayoutControl(createStore(), storage);
  before.choose("drive");
  before.change({ side: 0.5 });
  before.choose("debug");
  before.change({ lanesShown: false });

  const after = new LayoutControl(createStore(), storage);
  after.start("");
  expect(after.preset.value).toBe("debug");
  expect(after.layout.value.lanesShown).toBe(false);
  after.choose("drive");
  expect(after.layout.value).toEqual({ ...DEFAULTS.drive, side: 0.5 });
  expect(after.changed.value).toBe(true);
  after.reset();
  expect(after.layout.value).toEqual(DEFAULTS.drive);
  expect(after.changed.value).toBe(false);
});

test("a link opens the same layout in another browser, and outranks what is kept there", () => {
  const mine = new LayoutControl(createStore(), shelf());
  mine.choose("drive");
  mine.change({ edge: "left", lanesShown: true, lanes: 0.6 });
  const link = mine.link("http://robot:8000/?scene=off");

  const storage = shelf();
  const theirs = new LayoutControl(createStore(), storage);
  theirs.choose("debug");
  theirs.start(new URL(link).search);
  expect(theirs.preset.value).toBe("drive");
  expect(theirs.layout.value).toEqual(mine.layout.value);
  expect(new URL(link).searchParams.get("scene")).toBe("off");
});
