import { expect, test } from "vitest";
import type { FromRobot } from "../protocol/types";
import { PanelFrames } from "./external";

const ENTRY = { name: "example", title: "Example", url: "panels/example.js", kinds: ["channel/count", "pong"] };
const count = (stamp: number, channel = "count"): FromRobot => ({ type: "channel", channel, message: { stamp } });

test("a panel gets the frames of its kinds, the newest at once", () => {
  const frames = new PanelFrames();
  frames.want(ENTRY.kinds);
  frames.take(count(1));
  frames.take(count(2));
  const seen: FromRobot[] = [];
  const context = frames.context(ENTRY);
  context.on("channel/count", (frame) => seen.push(frame));
  expect(seen).toEqual([count(2)]);
  frames.take(count(3));
  frames.take(count(4, "others"));
  frames.take({ type: "pong", t: 1, stamp: 5 });
  expect(seen).toEqual([count(2), count(3)]);
  context.end();
  frames.take(count(6));
  expect(seen).toHaveLength(2);
});

test("a handler that ended gets nothing, the others go on", () => {
  const frames = new PanelFrames();
  frames.want(ENTRY.kinds);
  const seen: string[] = [];
  const context = frames.context(ENTRY);
  const end = context.on("pong", () => seen.push("first"));
  context.on("pong", () => seen.push("second"));
  end();
  frames.take({ type: "pong", t: 1, stamp: 5 });
  expect(seen).toEqual(["second"]);
});

test("a kind that the panel does not name is refused", () => {
  const context = new PanelFrames().context(ENTRY);
  expect(() => context.on("status", () => undefined)).toThrow("does not name status among its kinds");
});

test("what was before a jump is not given to who comes later", () => {
  const frames = new PanelFrames();
  frames.want(ENTRY.kinds);
  frames.take(count(1));
  frames.take({ type: "jump", stamp: 0 } as FromRobot);
  const seen: FromRobot[] = [];
  frames.context(ENTRY).on("channel/count", (frame) => seen.push(frame));
  expect(seen).toEqual([]);
});
