import { expect, test } from "vitest";
import { fromScene } from "./sceneMessages";

const SCENE = {} as Window;
const ORIGIN = "http://127.0.0.1:8081";
const stroke = { type: "key", down: true, code: "KeyW", key: "w", repeat: false };
const plain = { ctrlKey: false, altKey: false, metaKey: false, shiftKey: false };

test.each([
  { type: "ready" },
  { type: "blur" },
  { type: "frames", ms: 160 },
  { type: "shown", stamp: 1764.25 },
  { type: "held", codes: ["KeyW"] },
  { type: "pick", viewer: "5f3a", u: 0, v: 1 },
  { ...stroke, ...plain },
])("what the scene says is understood: $type", (data) => {
  expect(fromScene({ origin: ORIGIN, source: SCENE, data }, ORIGIN, SCENE)).toEqual(data);
});

test.each(["http://127.0.0.1:8080", "http://127.0.0.1:80810", "http://evil.example", "null", ""])(
  "a page of the origin '%s' says nothing here",
  (origin) => {
    const data = { ...stroke, ...plain };
    expect(fromScene({ origin, source: SCENE, data }, ORIGIN, SCENE)).toBe(null);
  },
);

test("nor does another window of the same origin, or any before there is a frame", () => {
  const event = { origin: ORIGIN, source: {} as Window, data: { type: "ready" } };
  expect(fromScene(event, ORIGIN, SCENE)).toBe(null);
  expect(fromScene({ ...event, source: SCENE }, null, SCENE)).toBe(null);
  expect(fromScene({ ...event, source: null }, ORIGIN, null)).toBe(null);
});

test.each([
  null,
  "ready",
  {},
  { type: "toString" },
  { type: "constructor" },
  { type: "held", codes: "KeyW" },
  { type: "held", codes: [1] },
  { type: "frames", ms: "160" },
  { type: "shown", stamp: Number.NaN },
  { type: "pick", viewer: "5f3a", u: 1.01, v: 0.5 },
  { type: "pick", viewer: "5f3a", u: Number.NaN, v: 0.5 },
  { type: "pick", viewer: "5f3a", u: "0.5", v: 0.5 },
  { type: "pick", viewer: "", u: 0.5, v: 0.5 },
  stroke,
  { ...stroke, ...plain, down: "true" },
  { ...stroke, ...plain, code: 87 },
])("what is no message is none: %j", (data) => {
  expect(fromScene({ origin: ORIGIN, source: SCENE, data }, ORIGIN, SCENE)).toBe(null);
});
