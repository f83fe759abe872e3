import { describe, expect, test } from "vitest";
import { FIRST_VIEW, toMap, toScreen } from "./mapProjection";
import {
  AT_REST,
  busy,
  type Done,
  type Input,
  type Sight,
  sketch,
  step,
  type Tool,
  type Tools,
  type Wish,
} from "./mapTools";

const size = { width: 400, height: 300 };
/** 20 px a metre; the middle of the screen is (0, 0). */
const SIGHT: Sight = { view: { ...FIRST_VIEW, scale: 20 }, size, follow: false };

const tool = (name: Tool): Input => ({ type: "tool", tool: name });
const down = (x: number, y: number, id = 1, button = 0): Input => ({ type: "down", id, at: { x, y }, button });
const move = (x: number, y: number, id = 1): Input => ({ type: "move", id, at: { x, y } });
const up = (x: number, y: number, id = 1): Input => ({ type: "up", id, at: { x, y } });
const key = (name: string, shift = false): Input => ({ type: "key", key: name, shift });
const click = (x: number, y: number): Input[] => [down(x, y), up(x, y)];

interface Run {
  tools: Tools;
  sight: Sight;
  wishes: Wish[];
  panned: boolean;
  last: Done;
}

function run(inputs: Input[], start: Tools = AT_REST, sight: Sight = SIGHT): Run {
  let last: Done = { tools: start, view: sight.view, wish: null, panned: false, taken: true };
  const wishes: Wish[] = [];
  let panned = false;
  for (const input of inputs) {
    last = step(last.tools, input, sight);
    sight = { ...sight, view: last.view };
    if (last.wish) wishes.push(last.wish);
    panned ||= last.panned;
  }
  return { tools: last.tools, sight, wishes, panned, last };
}

describe("looking", () => {
  test("a drag pans, and is no click", () => {
    const { sight, wishes, panned } = run([down(200, 150), move(240, 130), up(240, 130)]);
    expect(sight.view.x).toBeCloseTo(-2);
    expect(sight.view.y).toBeCloseTo(-1);
    expect(wishes).toEqual([]);
    expect(panned).toBe(true);
  });

  test("an unsteady click selects", () => {
    const { wishes, panned } = run([down(220, 150), move(222, 151), up(222, 151)]);
    expect(wishes).toEqual([{ type: "select", at: { x: 1.1, y: expect.closeTo(-0.05) } }]);
    expect(panned).toBe(false);
  });

  test("the wheel zooms about the pointer, or about the robot that is followed", () => {
    const at = { x: 300, y: 100 };
    const kept = toMap(SIGHT.view, size, at);
    const free = step(AT_REST, { type: "wheel", at, factor: 2 }, SIGHT);
    expect(toScreen(free.view, size, kept).x).toBeCloseTo(300);
    const followed = step(AT_REST, { type: "wheel", at, factor: 2 }, { ...SIGHT, follow: true });
    expect([followed.view.x, followed.view.y]).toEqual([0, 0]);
  });

  test("two fingers zoom and pan", () => {
    const { sight, wishes } = run([down(150, 150, 1), down(250, 150, 2), move(100, 160, 1), move(300, 160, 2)]);
    expect(sight.view.scale).toBeCloseTo(40);
    expect(toScreen(sight.view, size, { x: 0, y: 0 }).x).toBeCloseTo(200);
    expect(toScreen(sight.view, size, { x: 0, y: 0 }).y).toBeCloseTo(160);
    expect(wishes).toEqual([]);
  });
});

describe("a goal", () => {
  test("pressed, dragged and let go: place and heading", () => {
    const { wishes, tools } = run([tool("goal"), down(220, 130), move(220, 90), up(220, 90)]);
    expect(wishes).toEqual([{ type: "goal", place: { x: 1, y: 1 }, heading: expect.closeTo(Math.PI / 2) }]);
    expect(tools.tool).toBe("goal");
  });

  test("tapped: no heading; a second one follows", () => {
    const { wishes } = run([tool("goal"), ...click(220, 130), ...click(240, 130)]);
    expect(wishes.map((wish) => wish.type === "goal" && [wish.place.x, wish.heading])).toEqual([
      [1, null],
      [2, null],
    ]);
  });

  test("the heading is taken back by coming back", () => {
    const { wishes } = run([tool("goal"), down(220, 130), move(260, 130), move(224, 130), up(224, 130)]);
    expect(wishes[0]).toMatchObject({ heading: null });
  });

  test("a heading is the map's, whatever is up", () => {
    const robotUp = { ...SIGHT, view: { ...SIGHT.view, up: 0 } };
    const { wishes } = run([tool("goal"), down(200, 150), move(200, 100), up(200, 100)], AT_REST, robotUp);
    expect(wishes[0]).toMatchObject({ heading: expect.closeTo(0) });
  });

  test("a second finger makes no goal of it", () => {
    const { wishes, tools } = run([
      tool("goal"),
      down(200, 150, 1),
      down(260, 150, 2),
      up(260, 150, 2),
      up(200, 150, 1),
    ]);
    expect(wishes).toEqual([]);
    expect(tools.act.kind).toBe("none");
  });

  test("neither does a lost pointer, nor the other button", () => {
    expect(run([tool("goal"), down(200, 150), { type: "cancel", id: 1 }, up(200, 150)]).wishes).toEqual([]);
    const dragged = run([tool("goal"), down(200, 150, 1, 2), move(220, 150), up(220, 150)]);
    expect(dragged.wishes).toEqual([]);
    expect(dragged.sight.view.x).toBeCloseTo(-1);
  });
});

test("the robot is placed once", () => {
  const { wishes, tools } = run([tool("pose"), down(200, 150), move(260, 150), up(260, 150)]);
  expect(wishes).toEqual([{ type: "pose", place: { x: 0, y: 0 }, heading: expect.closeTo(0) }]);
  expect(tools.tool).toBe("look");
});

describe("a zone", () => {
  test("dragged is a rectangle", () => {
    const { wishes, tools } = run([tool("slow"), down(200, 150), move(240, 130), up(240, 130)]);
    const polygon = [
      { x: 0, y: 0 },
      { x: 2, y: 0 },
      { x: 2, y: 1 },
      { x: 0, y: 1 },
    ];
    expect(wishes).toEqual([
      {
        type: "zone",
        kind: "slow",
        polygon: polygon.map(({ x, y }) => ({ x: expect.closeTo(x), y: expect.closeTo(y) })),
      },
    ]);
    expect(tools).toMatchObject({ tool: "look", corners: [] });
  });

  test("clicked goes on until its first corner", () => {
    const open = run([tool("keep_out"), ...click(200, 150), ...click(260, 150), ...click(260, 90), move(230, 80)]);
    expect(open.wishes).toEqual([]);
    expect(sketch(open.tools, SIGHT)).toHaveLength(4);
    const { wishes } = run(click(204, 152), open.tools);
    expect(wishes[0]).toMatchObject({ type: "zone", kind: "keep_out" });
    expect((wishes[0] as { polygon: unknown[] }).polygon).toHaveLength(3);
  });

  test("a double click closes it too, with no corner more", () => {
    const { wishes } = run([
      tool("slow"),
      ...click(200, 150),
      ...click(260, 150),
      ...click(260, 90),
      ...click(261, 90),
    ]);
    expect((wishes[0] as { polygon: unknown[] }).polygon).toHaveLength(3);
  });

  test("two corners are none yet", () => {
    const { wishes, tools } = run([tool("slow"), ...click(200, 150), ...click(260, 150), ...click(200, 150)]);
    expect(wishes).toEqual([]);
    expect(tools.corners).toHaveLength(3);
  });

  test("corners are taken back, then all of it, then the tool", () => {
    const { tools } = run([tool("slow"), ...click(200, 150), ...click(260, 150), key("Backspace")]);
    expect(tools.corners).toHaveLength(1);
    const given = run([key("Escape")], tools);
    expect(given.tools).toMatchObject({ tool: "slow", corners: [] });
    expect(run([key("Escape")], given.tools).tools.tool).toBe("look");
  });

  test("a selected zone's corner is dragged", () => {
    const handle = { zone: "Slow 1", index: 2 };
    const { wishes } = run([
      { type: "down", id: 1, at: { x: 200, y: 150 }, button: 0, handle },
      move(220, 150),
      up(220, 150),
    ]);
    expect(wishes).toEqual([{ type: "corner", handle, to: { x: 1, y: 0 } }]);
  });
});

describe("by keys", () => {
  test("a cursor, a place, a heading, a goal", () => {
    const { wishes, tools } = run([
      key("ArrowRight", true),
      key("ArrowUp"),
      key("Enter"),
      key("ArrowUp"),
      key("ArrowLeft"),
      key("Enter"),
    ]);
    expect(wishes).toEqual([
      {
        type: "goal",
        place: { x: expect.closeTo(3.2), y: expect.closeTo(0.8) },
        heading: expect.closeTo(Math.PI / 2 + Math.PI / 12),
      },
    ]);
    expect(tools.act.kind).toBe("none");
  });

  test("Enter twice: without a heading", () => {
    expect(run([key("Enter"), key("Enter")]).wishes[0]).toMatchObject({ type: "goal", heading: null });
  });

  test("the view goes with the cursor", () => {
    const { sight, tools, panned } = run(Array.from({ length: 4 }, () => key("ArrowRight", true)));
    expect(panned).toBe(true);
    const seen = toScreen(sight.view, size, tools.cursor!);
    expect(seen.x).toBeLessThan(400);
    expect(tools.cursor!.x).toBeCloseTo((4 * 64) / 20);
  });

  test("a zone's corners, closed by Enter where the last one is", () => {
    const right = Array.from({ length: 3 }, () => key("ArrowRight"));
    const upwards = Array.from({ length: 3 }, () => key("ArrowUp"));
    const { wishes } = run([
      tool("slow"),
      key("Enter"),
      ...right,
      key("Enter"),
      ...upwards,
      key("Enter"),
      key("Enter"),
    ]);
    expect(wishes[0]).toMatchObject({ type: "zone", kind: "slow" });
  });

  test("Escape is the robot's as soon as no tool is in use", () => {
    expect(run([key("Escape")]).last.taken).toBe(false);
    const aiming = run([key("Enter")]);
    const freed = run([key("Escape")], aiming.tools);
    expect(freed.tools).toMatchObject({ tool: "goal", act: { kind: "none" } });
    expect(busy(run([key("Escape")], freed.tools).tools)).toBe(false);
  });

  test("other keys are the page's", () => {
    expect(run([key("w")]).last.taken).toBe(false);
  });
});

describe("the keyboard", () => {
  const focus = (on: boolean): Input => ({ type: "focus", on });

  test("brings a cursor to the middle, moves it, and takes it away again", () => {
    const there = run([focus(true), key("ArrowRight")]);
    expect(there.tools.cursor!.x).toBeCloseTo(0.8);
    expect(run([focus(false)], there.tools).tools.cursor).toBeNull();
  });

  test("sets a goal, and turns it before it is sent", () => {
    const { wishes } = run([focus(true), key("Enter"), key("ArrowLeft"), key("Enter")]);
    expect(wishes).toEqual([{ type: "goal", place: { x: 0, y: 0 }, heading: Math.PI }]);
  });

  test("leaves no half-set goal behind, but corners to continue with", () => {
    expect(run([focus(true), key("Enter"), focus(false)]).tools.act).toEqual({ kind: "none" });
    expect(run([focus(true), tool("slow"), key("Enter"), focus(false)]).tools.corners).toHaveLength(1);
  });
});

test("the tool of points takes a click and pans with a drag", () => {
  const tools: Tools = { ...AT_REST, tool: "point" };
  const sight: Sight = {
    view: { x: 0, y: 0, scale: 50, up: Math.PI / 2 },
    size: { width: 200, height: 200 },
    follow: false,
  };
  const pressed = step(tools, { type: "down", id: 1, at: { x: 150, y: 100 }, button: 0 }, sight);
  const clicked = step(pressed.tools, { type: "up", id: 1, at: { x: 150, y: 100 } }, sight);
  expect(clicked.wish?.type).toBe("point");
  expect(clicked.wish).toMatchObject({ at: { x: expect.closeTo(1), y: expect.closeTo(0) } });
  const dragged = step(pressed.tools, { type: "move", id: 1, at: { x: 100, y: 100 } }, sight);
  expect(step(dragged.tools, { type: "up", id: 1, at: { x: 100, y: 100 } }, sight).wish).toBeNull();
  expect(dragged.panned).toBe(true);
  const entered = step({ ...tools, cursor: { x: 1, y: 2 } }, { type: "key", key: "Enter", shift: false }, sight);
  expect(entered.wish).toEqual({ type: "point", at: { x: 1, y: 2 } });
});
