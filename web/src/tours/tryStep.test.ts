import { expect, test } from "vitest";
import { NO_STEP } from "./tourEdits";
import { desiresOf } from "./tryStep";

const trial = { language: "fr", fallback: "en", poster: "tour:lab", serves: () => true };
const kinds = (step: typeof NO_STEP, more: Partial<typeof trial> = {}) =>
  desiresOf(step, { ...trial, ...more }).map((desire) => desire.class);

test("all that a step names is desired, for a while", () => {
  const step: typeof NO_STEP = {
    ...NO_STEP,
    say: { en: "Hello", fr: "Bonjour" },
    point: [1, 2, 1.5],
    gesture: { class: "Wave", params: { times: 2 } },
    expression: "happy",
  };
  const desires = desiresOf(step, trial);
  expect(desires.map((desire) => [desire.class, desire.params])).toEqual([
    ["Say", { text: "Bonjour", language: "fr" }],
    ["PointAt", { x: 1, y: 2, z: 1.5, frame: "map" }],
    ["Wave", { times: 2 }],
    ["Express", { expression: "happy" }],
  ]);
  expect(desires.every(({ ttl }) => (ttl ?? 0) > 0)).toBe(true);
});

test("without a text in the language, the first is said in its own", () => {
  expect(desiresOf({ ...NO_STEP, say: { en: "Hello" } }, trial)[0]?.params).toEqual({ text: "Hello", language: "en" });
});

test("it looks at points and posters; where visitors are, the guide knows", () => {
  expect(desiresOf({ ...NO_STEP, look: "poster" }, trial)[0]?.params).toEqual({ place: "tour:lab" });
  expect(kinds({ ...NO_STEP, look: [1, 2, 1] })).toEqual(["LookAt"]);
  expect(kinds({ ...NO_STEP, look: "visitors" })).toEqual([]);
});

test("what nothing here serves is left out", () => {
  expect(
    kinds({ ...NO_STEP, expression: "happy", say: { en: "Hi" } }, {
      serves: (kind: string) => kind === "Say",
    } as never),
  ).toEqual(["Say"]);
});
