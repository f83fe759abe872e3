import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { READY_WITHIN_MS, SceneFrame } from "./sceneFrame";
import type { FromScene, Stroke } from "./sceneMessages";

const OWN = "http://127.0.0.1:8080/viser/";
const APART = "http://127.0.0.1:8081/viser/";
const W = {
  ...{ type: "key", down: true, code: "KeyW", key: "w", repeat: false },
  ...{ ctrlKey: false, altKey: false, metaKey: false, shiftKey: false },
} as Stroke;

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

function framed(...addresses: string[]) {
  const inner = { postMessage: vi.fn() };
  const struck: string[] = [];
  const frames: number[] = [];
  const scene = new SceneFrame({
    own: OWN,
    find: async () => addresses.shift()!,
    inner: () => inner as unknown as Window,
    strike: ({ code, down }) => struck.push(`${code} ${down ? "down" : "up"}`),
    frames: (ms) => frames.push(ms),
  });
  const say = (data: FromScene, origin = new URL(scene.address.value!).origin) =>
    scene.receive({ origin, source: inner as unknown as Window, data });
  return { scene, say, inner, struck, frames };
}

test("the view is shown once its page says that it is there, and is sent the keys that are ours", async () => {
  const { scene, say, inner, frames } = framed(APART);
  scene.takeKeys(["KeyW"]);
  await scene.open();
  expect(scene.address.value).toBe(APART);
  expect(inner.postMessage).not.toHaveBeenCalled();
  scene.loaded();
  say({ type: "ready" });
  vi.advanceTimersByTime(READY_WITHIN_MS);
  expect(scene.state.value).toBe("shown");
  expect(inner.postMessage.mock.calls).toEqual([[{ type: "keys", codes: ["KeyW"] }, "http://127.0.0.1:8081"]]);
  say({ type: "frames", ms: 20 });
  expect(frames).toEqual([20]);
});

test("the view hears whether somebody drives", async () => {
  const { scene, say, inner } = framed(APART);
  scene.drives(false); // not there yet
  await scene.open();
  say({ type: "ready" });
  scene.drives(true);
  expect(inner.postMessage).toHaveBeenLastCalledWith({ type: "driving", driving: true }, "http://127.0.0.1:8081");
});

test("the view hears how far aside the head follows it, again when its page was loaded again", async () => {
  const { scene, say, inner } = framed(APART);
  await scene.open();
  scene.limits(null); // as it is
  scene.limits(0.5);
  say({ type: "ready" });
  const limits = () => inner.postMessage.mock.calls.map(([said]) => said).filter(({ type }) => type === "soft_limit");
  expect(limits()).toEqual([{ type: "soft_limit", angle: 0.5 }]);
  scene.limits(0.5);
  scene.limits(null);
  expect(limits().at(-1)).toEqual({ type: "soft_limit", angle: null });
  expect(limits()).toHaveLength(2);
});

test("pages of other origins are not heard", async () => {
  const { scene, say, struck } = framed(APART);
  await scene.open();
  say({ type: "ready" }, "http://127.0.0.1:8080");
  say(W, "http://evil.example:8081");
  expect(scene.state.value).toBe("loading");
  expect(struck).toEqual([]);
});

test("a second port that shows no view gives way to our own, and only that one is missed", async () => {
  const { scene, say } = framed(APART);
  await scene.open();
  scene.loaded(); // the browser's page of an error
  vi.advanceTimersByTime(READY_WITHIN_MS);
  expect([scene.state.value, scene.address.value]).toEqual(["loading", OWN]);
  scene.loaded();
  vi.advanceTimersByTime(READY_WITHIN_MS);
  expect(scene.state.value).toBe("missing");
  say({ type: "ready" });
  expect(scene.state.value).toBe("shown");
});

test("an error that was loaded while the robot did not answer is loaded again when it does", async () => {
  const { scene } = framed(OWN, OWN, OWN);
  await scene.answered();
  expect([scene.load.value, scene.address.value]).toEqual([1, OWN]);
  await scene.answered();
  expect(scene.load.value).toBe(1); // on its way
  scene.loaded();
  await scene.answered();
  expect(scene.load.value).toBe(2);
  vi.advanceTimersByTime(READY_WITHIN_MS);
  expect(scene.state.value).toBe("loading");
});

test("a robot that answers again is asked at once, elsewhere if it was started again elsewhere", async () => {
  const { scene, say, inner } = framed(APART, APART, OWN);
  await scene.open();
  say({ type: "ready" });
  const loads = scene.load.value;
  await scene.answered();
  expect(scene.load.value).toBe(loads);
  expect(inner.postMessage).toHaveBeenLastCalledWith({ type: "reconnect" }, "http://127.0.0.1:8081");
  await scene.answered();
  expect([scene.load.value, scene.address.value]).toEqual([loads + 1, OWN]);
});

test.each([
  ["closes", (scene: SceneFrame) => scene.close()],
  ["loads again", (scene: SceneFrame) => void scene.open()],
])("what is held in a frame that %s is let go of", async (_, end) => {
  const { scene, say, struck } = framed(APART, APART);
  await scene.open();
  say({ type: "ready" });
  say(W);
  end(scene);
  await vi.advanceTimersByTimeAsync(0);
  expect(struck).toEqual(["KeyW down", "KeyW up"]);
});

test("an address that is found after the view was closed loads nothing", async () => {
  const { scene } = framed(APART);
  const opening = scene.open();
  scene.close();
  await opening;
  expect(scene.address.value).toBe(null);
});

test("a viewpoint is asked for with a number of its own, again of a page that was loaded again, and reported", async () => {
  const { scene, say, inner } = framed(APART, APART);
  const asked = () =>
    inner.postMessage.mock.calls.map(([message]) => message).filter(({ type }) => type === "viewpoint");
  const camera = { type: "camera", arrived: true, bearing: 0, gaze: 0 } as const;
  await scene.open();
  say({ type: "ready" });
  scene.look("top");
  scene.look("top");
  expect(asked().map(({ number }) => number)).toEqual([1, 2]);
  say({ ...camera, viewpoint: "top", number: 1 });
  expect(scene.camera.value).toEqual({ viewpoint: "top", arrived: false });
  say({ ...camera, viewpoint: "top", number: 2 });
  expect(scene.camera.value).toEqual({ viewpoint: "top", arrived: true });
  say({ type: "ready" });
  expect(asked().at(-1)).toEqual({ type: "viewpoint", viewpoint: "top", number: 2 });
});

test("a click in the view is passed on, but none of another origin", async () => {
  const { scene, say } = framed(APART);
  const clicked = vi.fn();
  scene.onPicked = clicked;
  await scene.open();
  say({ type: "ready" });
  const click = { type: "pick", viewer: "5f3a", u: 0.5, v: 0.25 } as const;
  say(click, "http://evil.example:8081");
  expect(clicked).not.toHaveBeenCalled();
  say(click);
  expect(clicked.mock.calls).toEqual([[click]]);
});
