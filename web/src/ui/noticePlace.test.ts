import { expect, test } from "vitest";
import { type Box, covers, placed } from "./noticePlace";

const ROOM = { left: 0, top: 60, width: 800, height: 400 };
const WANTED = { x: 400, y: 72 };
const SIZES = [
  { width: 400, height: 40 },
  { width: 200, height: 60 },
];
const control = (left: number, top: number, width: number, height: number, weight = 10) => ({
  left,
  top,
  width,
  height,
  weight,
});
const inside = (box: Box) =>
  box.left >= ROOM.left &&
  box.top >= ROOM.top &&
  box.left + box.width <= ROOM.left + ROOM.width &&
  box.top + box.height <= ROOM.top + ROOM.height;

test("with nothing in the way it is where it is looked for", () => {
  expect(placed(SIZES, ROOM, WANTED, [])).toEqual({ left: 200, top: 72, width: 400, height: 40 });
});

test("it keeps off what can be pressed, wherever that is, as long as there is room", () => {
  let seed = 7;
  const random = (most: number) => {
    seed = (seed * 48_271) % 2_147_483_647;
    return (seed / 2_147_483_647) * most;
  };
  for (let turn = 0; turn < 100; turn++) {
    const controls = Array.from({ length: 8 }, () => control(random(760), 60 + random(360), 40, 40));
    const box = placed(SIZES, ROOM, WANTED, controls);
    expect(inside(box)).toBe(true);
    expect(covers(box, controls)).toBe(0);
  }
});

test("between two columns it is narrow; there is no room for the wide one", () => {
  const box = placed(SIZES, ROOM, WANTED, [control(0, 60, 280, 400), control(520, 60, 280, 400)]);
  expect(box).toMatchObject({ width: 200, height: 60, top: 72 });
});

test("where all is covered by something, what moves or stops the robot is left free", () => {
  const stop = control(300, 60, 200, 100, 100);
  const box = placed(SIZES, ROOM, WANTED, [control(0, 60, 800, 400, 0.1), stop]);
  expect(covers(box, [stop])).toBe(0);
});

test("a window that is smaller than the notice shows what it can", () => {
  const small = { left: 0, top: 0, width: 100, height: 30 };
  expect(placed(SIZES, small, { x: 50, y: 0 }, [])).toMatchObject({ left: 0, top: 0, width: 100, height: 30 });
});
