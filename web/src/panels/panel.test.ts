import { effect } from "@preact/signals";
import { expect, test } from "vitest";
import type { FromRobot, Landmark } from "../protocol/types";
import type { App } from "../state/context";
import { createStore } from "../state/store";
import { offeredTabs, panel, tabsOf } from "./panel";

const Card = () => null;
const always = () => true;

function ids(panels: Parameters<typeof tabsOf>[0], app: App, phone = false): string[] {
  return tabsOf(panels, app, phone).map(({ id }) => id);
}

test("a panel that says nothing else is there once a message of its type has come", () => {
  const app = { store: createStore() } as App;
  const panels = [panel({ type: "landmarks", tab: "Found", Card })];
  expect(ids(panels, app)).toEqual([]);
  app.store.latest.put({ type: "landmarks", landmarks: [] });
  expect(ids(panels, app)).toEqual(["found"]);
});

test("cards of one tab keep the registry's order, and tabs that of their first cards", () => {
  const app = { store: createStore() } as App;
  const [intention, load, desires] = [
    panel({ type: "intention", tab: "Attention", Card, offered: always }),
    panel({ type: "load", tab: "Load", Card, offered: (_, phone) => phone }),
    panel({ type: "desires", tab: "Attention", Card, offered: always }),
  ];
  expect(tabsOf([intention, load, desires], app, true).map((tab) => [tab.title, tab.panels])).toEqual([
    ["Attention", [intention, desires]],
    ["Load", [load]],
  ]);
  expect(ids([intention, load, desires], app)).toEqual(["attention"]);
});

test("a tab's badge and alarm are those of its cards, by their newest messages", () => {
  const app = { store: createStore() } as App;
  const panels = [
    panel({ type: "perceived", tab: "Found", Card, offered: always }),
    panel({
      type: "landmarks",
      tab: "Found",
      Card,
      offered: always,
      badge: (message) => message?.landmarks.length ?? 0,
      alarm: (message) => (message?.landmarks.length ?? 0) > 1,
    }),
  ];
  const shown = () => tabsOf(panels, app, false).map(({ badge, alarm }) => [badge, alarm])[0];
  expect(shown()).toEqual([0, false]);
  app.store.latest.put({ type: "landmarks", landmarks: [{}, {}] as Landmark[] });
  expect(shown()).toEqual([2, true]);
});

test("the tabs are made again only by a message that changes what they show", () => {
  const app = { store: createStore() } as App;
  const panels = [
    panel({
      type: "landmarks",
      tab: "Found",
      Card,
      offered: always,
      badge: (message) => message?.landmarks.length ?? 0,
    }),
    panel({ type: "perceived", tab: "Load", Card }),
  ];
  const tabs = offeredTabs(panels, app, false);
  let made = 0;
  const end = effect(() => {
    void tabs.value;
    made += 1;
  });
  const landmarks = (count: number) =>
    app.store.latest.put({ type: "landmarks", landmarks: Array.from({ length: count }) as Landmark[] });
  expect(made).toBe(1);
  landmarks(0);
  landmarks(0);
  expect(made).toBe(1);
  landmarks(1);
  expect(made).toBe(2);
  for (let stamp = 0; stamp < 5; stamp++) app.store.latest.put({ type: "perceived", stamp } as FromRobot);
  expect(made).toBe(3); // once, as its tab came
  expect(tabs.value.map(({ id, badge }) => [id, badge])).toEqual([
    ["found", 1],
    ["load", 0],
  ]);
  end();
});
