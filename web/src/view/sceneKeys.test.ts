import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { SceneKeys, SILENT_MS } from "./sceneKeys";
import type { Stroke } from "./sceneMessages";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

function stroke(code: string, down = true): Stroke {
  const plain = { ctrlKey: false, altKey: false, metaKey: false, shiftKey: false };
  return { type: "key", down, code, key: code, repeat: false, ...plain };
}

function scene() {
  const struck: string[] = [];
  const keys = new SceneKeys(({ code, down }) => struck.push(`${code} ${down ? "down" : "up"}`));
  return { keys, struck };
}

test("keys pass, down and up", () => {
  const { keys, struck } = scene();
  keys.take(stroke("KeyW"));
  keys.take(stroke("KeyW", false));
  keys.release();
  expect(struck).toEqual(["KeyW down", "KeyW up"]);
});

test("a frame that loses the keyboard lets go of all that was held in it", () => {
  const { keys, struck } = scene();
  keys.take(stroke("KeyW"));
  keys.take(stroke("KeyA"));
  keys.take({ type: "blur" });
  keys.take({ type: "blur" });
  expect(struck).toEqual(["KeyW down", "KeyA down", "KeyW up", "KeyA up"]);
});

test("a key goes on as long as the frame says that it is held", () => {
  const { keys, struck } = scene();
  keys.take(stroke("KeyW"));
  for (let i = 0; i < 100; i += 1) {
    vi.advanceTimersByTime(100);
    keys.take({ type: "held", codes: ["KeyW"] });
  }
  expect(struck).toEqual(["KeyW down"]);
});

test("a key whose release was lost is let go of when the frame does not say it any more", () => {
  const { keys, struck } = scene();
  keys.take(stroke("KeyW"));
  keys.take(stroke("KeyA"));
  keys.take({ type: "held", codes: ["KeyA"] });
  expect(struck).toEqual(["KeyW down", "KeyA down", "KeyW up"]);
});

test("a frame that falls silent, as one that hangs or is gone, lets go, once", () => {
  const { keys, struck } = scene();
  keys.take(stroke("KeyW"));
  vi.advanceTimersByTime(SILENT_MS - 50);
  expect(struck).toEqual(["KeyW down"]);
  vi.advanceTimersByTime(250);
  expect(struck).toEqual(["KeyW down", "KeyW up"]);
  vi.advanceTimersByTime(10_000);
  expect(struck).toEqual(["KeyW down", "KeyW up"]);
  expect(vi.getTimerCount()).toBe(0);
});

test("a page that was busy itself hears first what waited", () => {
  const { keys, struck } = scene();
  keys.take(stroke("KeyW"));
  vi.setSystemTime(Date.now() + 2000); // nothing ran for two seconds
  vi.spyOn(performance, "now").mockReturnValue(performance.now() + 2000);
  vi.advanceTimersByTime(100);
  keys.take({ type: "held", codes: ["KeyW"] });
  vi.advanceTimersByTime(100);
  expect(struck).toEqual(["KeyW down"]);
  vi.restoreAllMocks();
});
