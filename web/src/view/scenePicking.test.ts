import { signal } from "@preact/signals";
import { beforeEach, expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { FromRobot, Landmark, SceneClick, ScenePoint } from "../protocol/types";
import { createStore } from "../state/store";
import type { PointTarget } from "../tours/tourPath";
import { pickedOf, ScenePicking } from "./scenePicking";

const CLICK = { type: "pick", viewer: "5f3a", u: 0.4, v: 0.6 } as const;
const FLOOR: ScenePoint = { kind: "floor", frame: "map", x: 2, y: 1, z: 0, text: null, landmark: null };
const POSTER: ScenePoint = { kind: "poster", frame: "map", x: 3, y: 0, z: 1.2, text: "tour:arm", landmark: 7 };
const NOTHING: ScenePoint = { kind: "nothing", frame: "odom", x: null, y: null, z: null, text: null, landmark: null };
const ARM = { text: "tour:arm", id: 7, frame: "map", x: 3, y: 0, z: 1.2, heading: 0 } as Landmark;

function shown() {
  const store = createStore();
  store.link.value = { phase: "live", retryAt: 0 };
  store.hello.value = { channels: { map: true }, classes: [] } as unknown as typeof store.hello.value;
  store.latest.put({ type: "landmarks", landmarks: [ARM] } as unknown as FromRobot);
  const answers: ((point: ScenePoint | Problem) => void)[] = [];
  const scenePoint = vi.fn(
    (_: SceneClick) =>
      new Promise<ScenePoint>((resolve, reject) =>
        answers.push((answer) => (answer instanceof Problem ? reject(answer) : resolve(answer))),
      ),
  );
  const pointing = { target: signal<PointTarget | null>(null), scene: vi.fn() };
  return { store, answers, scenePoint, pointing, picking: new ScenePicking(store, { scenePoint }, pointing) };
}

let parts: ReturnType<typeof shown>;
beforeEach(() => void (parts = shown()));

test("a click is asked about, and what is there is what was picked", async () => {
  const { answers, picking, scenePoint } = parts;
  const done = picking.click(CLICK);
  expect(scenePoint.mock.calls).toEqual([[{ viewer: "5f3a", u: 0.4, v: 0.6 }]]);
  answers[0]!(POSTER);
  await done;
  expect(picking.picked.value).toMatchObject({ kind: "poster", poster: ARM, onMap: true, u: 0.4, v: 0.6 });
  picking.close();
  expect(picking.picked.value).toBe(null);
});

test("while a step waits for its point, a click is that point and nothing else", async () => {
  const { answers, picking, pointing } = parts;
  pointing.target.value = { path: "stops.0.do.0", part: "point" };
  const done = picking.click(CLICK);
  answers[0]!(FLOOR);
  await done;
  expect(pointing.scene.mock.calls).toEqual([[FLOOR]]);
  expect(picking.picked.value).toBe(null);
});

test("what was closed, or clicked after, while the robot had not answered is not shown any more", async () => {
  const { answers, picking } = parts;
  const [first, second] = [picking.click(CLICK), picking.click({ ...CLICK, u: 0.9 })];
  answers[1]!(FLOOR);
  answers[0]!(POSTER);
  await Promise.all([first, second]);
  expect(picking.picked.value).toMatchObject({ kind: "floor", u: 0.9 });
  const third = picking.click(CLICK);
  expect(picking.picked.value).toBe(null);
  picking.close();
  answers[2]!(FLOOR);
  await third;
  expect(picking.picked.value).toBe(null);
});

test("a refusal is said, and nothing is picked", async () => {
  const { answers, picking, store } = parts;
  const done = picking.click(CLICK);
  answers[0]!(new Problem(409, "No such view", "That 3D view is not open any more: reload the page."));
  await done;
  expect(store.notices.value.map(({ text }) => text)).toEqual(["That 3D view is not open any more: reload the page."]);
  expect(picking.picked.value).toBe(null);
});

test.each([
  ["a recording", () => void (parts.store.playback.value = {} as typeof parts.store.playback.value)],
  ["a page that is not connected", () => void (parts.store.link.value = { phase: "lost", retryAt: 0 })],
  [
    "a robot without a map",
    () =>
      void (parts.store.hello.value = {
        channels: { map: false },
        classes: [],
      } as unknown as typeof parts.store.hello.value),
  ],
])("on %s nobody is asked", async (_, make) => {
  make();
  await parts.picking.click(CLICK);
  expect(parts.scenePoint).not.toHaveBeenCalled();
});

test("the sky, and a poster that is gone, are nothing", () => {
  expect(pickedOf(NOTHING, CLICK, [ARM])).toBe(null);
  expect(pickedOf(POSTER, CLICK, [{ ...ARM, id: 8 }])).toBe(null);
  expect(pickedOf({ ...POSTER, frame: "odom" }, CLICK, [ARM])).toBe(null);
  expect(pickedOf({ ...FLOOR, frame: "odom" }, CLICK, [])).toMatchObject({ kind: "floor", onMap: false, poster: null });
});
