import { signal } from "@preact/signals";
import { beforeEach, expect, test, vi } from "vitest";
import type { MapControl } from "../map/mapControl";
import { AT_REST, type Tool } from "../map/mapTools";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { CameraPoint, ScenePoint, Tour } from "../protocol/types";
import { createStore } from "../state/store";
import type { TourControl } from "./tourControl";
import { NO_STEP } from "./tourEdits";
import { TourPointing } from "./tourPointing";
import { aStop, aTour } from "./tours.fixture";

vi.mock("../ui/media", async () => ({ narrow: (await import("@preact/signals")).signal(false) }));

const TARGET = { path: "stops.0.do.0", part: "point" } as const;
const POINT: ScenePoint = { kind: "seen", frame: "map", x: 2.004, y: -1.5, z: 0.777, text: null, landmark: null };
const SEEN: CameraPoint = { x: 3.004, y: 0.5, z: 1.246, measured: true };

function opened() {
  const store = createStore();
  const tools = signal(AT_REST);
  const choose = (tool: Tool) => void (tools.value = { ...AT_REST, tool: tools.peek().tool === tool ? "look" : tool });
  const map = { tools, choose, onPoint: () => undefined } as unknown as MapControl;
  const draft = signal<Tour | null>(aTour([aStop("desk", { do: [{ ...NO_STEP, point: [0, 0, 1] }] })]));
  const edit = vi.fn(async (change: (tour: Tour) => Tour) => void (draft.value = change(draft.peek()!)));
  const cameraPoint = vi.fn(async (): Promise<CameraPoint> => SEEN);
  const pointing = new TourPointing(store, { cameraPoint } as unknown as Rest, map, {
    draft,
    edit,
  } as unknown as TourControl);
  pointing.start();
  return { store, pointing, draft, cameraPoint, point: () => draft.value!.stops[0]!.do[0]!.point, tools };
}

let parts: ReturnType<typeof opened>;
beforeEach(() => void (parts = opened()));

test("a click in the 3D view is the step's point, with its height", () => {
  const { point, pointing, tools } = parts;
  pointing.choose(TARGET);
  expect(pointing.isFor(TARGET)).toBe(true);
  pointing.scene(POINT);
  expect(point()).toEqual([2, -1.5, 0.78]);
  expect(pointing.target.value).toBe(null);
  expect(tools.value.tool).toBe("look");
});

test("a click in the camera's picture is the step's point, where the robot says that it lies", async () => {
  const { cameraPoint, point, pointing, store } = parts;
  pointing.choose(TARGET);
  await pointing.picture(10.5, 0.25, 0.75);
  expect(cameraPoint.mock.calls).toEqual([[{ stamp: 10.5, u: 0.25, v: 0.75 }]]);
  expect(point()).toEqual([3, 0.5, 1.25]);
  expect(pointing.target.value).toBe(null);
  expect(store.notices.value).toEqual([]);
});

test("where the camera measured no distance the point is taken, and said to be a guess", async () => {
  const { cameraPoint, point, pointing, store } = parts;
  cameraPoint.mockResolvedValue({ ...SEEN, measured: false });
  pointing.choose(TARGET);
  await pointing.picture(10.5, 0.25, 0.75);
  expect(point()).toEqual([3, 0.5, 1.25]);
  expect(store.notices.value.map(({ level }) => level)).toEqual(["warning"]);
});

test("a click in a picture that the robot has no more leaves the step as it is, and says so", async () => {
  const { cameraPoint, point, pointing, store } = parts;
  cameraPoint.mockRejectedValue(new Problem(404, "Unknown", "No image of this time is kept."));
  pointing.choose(TARGET);
  await pointing.picture(10.5, 0.25, 0.75);
  expect(point()).toEqual([0, 0, 1]);
  expect(pointing.isFor(TARGET)).toBe(true);
  expect(store.notices.value.map(({ level, text }) => [level, text])).toEqual([
    ["error", "No image of this time is kept."],
  ]);
});

test.each([
  ["the sky", { ...POINT, kind: "nothing", x: null, y: null, z: null }, "info"],
  ["what has no place on the map", { ...POINT, frame: "odom" }, "error"],
] as [string, ScenePoint, string][])("a click on %s leaves the step as it is, and says so", (_, at, level) => {
  const { point, pointing, store } = parts;
  pointing.choose(TARGET);
  pointing.scene(at);
  expect(point()).toEqual([0, 0, 1]);
  expect(pointing.isFor(TARGET)).toBe(true);
  expect(store.notices.value.map((notice) => notice.level)).toEqual([level]);
});

test("the map comes for it where the 3D view is not in sight, and else stays away", () => {
  const { pointing, store } = parts;
  pointing.choose(TARGET);
  expect([store.mapPlace.value, store.tab.value]).toEqual(["view", "tour"]);
  pointing.choose(null);
  store.mapPlace.value = "tab";
  store.sceneShown.value = true;
  pointing.choose(TARGET);
  expect(store.mapPlace.value).toBe("tab");
  pointing.choose(null);
  store.camera.value = "large";
  pointing.choose(TARGET);
  expect(store.mapPlace.value).toBe("view");
});
