import { describe, expect, test, vi } from "vitest";
import type { Rest } from "../protocol/rest";
import type { Desire } from "../protocol/types";
import type { Session } from "../state/session";
import { createStore } from "../state/store";
import { MapControl } from "./mapControl";

const goal = (id: string, kind: Desire["source"]["kind"]): Desire => ({
  id,
  class: "GoTo",
  intensity: 8,
  utility: 4,
  security: false,
  params: { x: 1, y: 2 },
  source: { kind, name: kind, rule: "", event: "", applied: null, motive: null },
  created: 1,
  expires: null,
  modulation: null,
});

function page(desires: Desire[], setGoal = async () => ({})) {
  const said: string[] = [];
  const rest = {
    setGoal: vi.fn(() => setGoal().then(() => void said.push("goal"))),
    cancelGoal: vi.fn(async () => void said.push("cancel")),
    removeDesire: vi.fn(async (id: string) => void said.push(`remove ${id}`)),
  };
  const store = createStore();
  store.latest.put({ type: "desires", stamp: 1, exploited: [], accomplishments: [], ended: [], progress: [], desires });
  store.link.value = { phase: "live", retryAt: 0 };
  const map = new MapControl(store, { rest: rest as unknown as Rest } as Session);
  const sent = () =>
    vi.waitFor(() => expect(store.notices.value.map(({ text }) => text)).toEqual(["The goal is cancelled."]));
  return { map, said, sent };
}

describe("stopping", () => {
  test("cancels what was asked for, and what the robot wants by itself", async () => {
    const { map, said, sent } = page([goal("a", "operator"), goal("b", "motivation"), goal("c", "rest")]);
    expect(map.stop()).toBe(true);
    await sent();
    expect(said).toEqual(["cancel", "remove b"]);
  });

  test("asks for nothing of a robot that goes nowhere: what it gave up stays to be read", () => {
    const { map, said } = page([{ ...goal("a", "operator"), class: "SLAM" }]);
    expect(map.stop()).toBe(false);
    expect(said).toEqual([]);
  });

  test("ends exploring, and where there is no goal just now, too", async () => {
    const exploring = { ...goal("e", "operator"), class: "Explore", params: {} };
    const { map, said, sent } = page([goal("b", "motivation"), exploring]);
    expect(map.stop()).toBe(true);
    await sent();
    expect(said).toEqual(["cancel", "remove b"]);
    const alone = page([exploring]);
    expect(alone.map.stop()).toBe(true);
    await alone.sent();
    expect(alone.said).toEqual(["cancel"]);
  });

  test("comes after a goal that is only on its way to the robot", async () => {
    let arrive = () => {};
    const { map, said, sent } = page([], () => new Promise((resolve) => (arrive = () => resolve({}))));
    void map.goTo(1, 2, null);
    expect(map.stop()).toBe(true);
    expect(said).toEqual([]);
    arrive();
    await sent();
    expect(said).toEqual(["goal", "cancel"]);
  });
});
