import { expect, test } from "vitest";
import type { DesireClass } from "../protocol/types";
import { acts, say } from "./acts";

const scale = { intensity: 8, utility: 8 };
const cls = (name: string, served = true) => ({ name, served }) as DesireClass;

test("only what the robot can do is offered", () => {
  expect(acts([cls("Say")], scale)).toEqual([]);
  expect(acts([cls("Wave"), cls("Express", false)], scale).map(({ title }) => title)).toEqual(["Wave"]);
  expect(acts([cls("Express")], scale).map(({ desire }) => desire.params)).toContainEqual({ expression: "happy" });
});

test("each act and sentence ends by itself", () => {
  const all = [
    say("Hello", scale),
    ...acts([cls("Wave"), cls("Express"), cls("Rest")], scale).map((act) => act.desire),
  ];
  for (const desire of all) expect(desire.ttl).toBeGreaterThan(0);
});
