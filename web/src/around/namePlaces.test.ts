import { expect, test } from "vitest";
import type { Box } from "./layer";
import { freePlace, namePlace, overlap } from "./namePlaces";

/** A small strip's part above its foot, as beside a narrow view; its age and its buttons. */
const BOUNDS = { width: 187, height: 45 };
const AGE: Box = { x: 6, y: 6, width: 56, height: 18 };
const TOOLS: Box = { x: 127, y: 4, width: 56, height: 26 };
const NAME = { width: 98, height: 15 };
const within = ({ x, y, width, height }: Box) =>
  x >= 0 && y >= 0 && x + width <= BOUNDS.width && y + height <= BOUNDS.height;

test("a name stands over its mark where nothing is", () => {
  expect(freePlace(NAME, { x: 90, bottom: 40 }, BOUNDS, [])).toEqual({ x: 41, y: 25, ...NAME });
});

test("at the edges it stays within", () => {
  expect(freePlace(NAME, { x: 0, bottom: 4 }, BOUNDS, [])).toEqual({ x: 1, y: 1, ...NAME });
  expect(freePlace(NAME, { x: 187, bottom: 99 }, BOUNDS, [])).toEqual({ x: 88, y: 29, ...NAME });
});

test("wherever a person is, their name is over neither the picture's age nor the buttons nor the face", () => {
  for (let x = 0; x <= 187; x += 3)
    for (let y = 0; y <= 45; y += 3) {
      const face = { x: x - 5, y: y - 6, width: 10, height: 12 };
      const taken = [AGE, TOOLS, face];
      const place = freePlace({ width: 60, height: 15 }, { x, bottom: face.y - 3 }, BOUNDS, taken);
      expect([x, y, place && within(place), place && taken.some((box) => overlap(place, box))]).toEqual([
        x,
        y,
        true,
        false,
      ]);
    }
});

test("of the free places it takes the nearest", () => {
  const wall = { x: 60, y: 0, width: 60, height: 20 };
  expect(freePlace({ width: 40, height: 15 }, { x: 90, bottom: 15 }, BOUNDS, [wall])).toEqual({
    x: 70,
    y: 21,
    width: 40,
    height: 15,
  });
});

test("a name that has no room is written in short, and over something only where that has none either", () => {
  const long = { ...NAME, text: "Person 12, 3.4 m" };
  const short = { width: 60, height: 15, text: "Person 12" };
  const at = { x: 90, bottom: 20 };
  const middle = { x: 62, y: 0, width: 65, height: 22 };
  const low = { x: 70, y: 22, width: 20, height: 23 };
  expect(namePlace([long, short], at, BOUNDS, [AGE, TOOLS, middle]).name).toBe(long);
  const { name, box } = namePlace([long, short], at, BOUNDS, [AGE, TOOLS, middle, low]);
  expect(name).toBe(short);
  expect([AGE, TOOLS, middle, low].some((other) => overlap(box, other))).toBe(false);
  const whole = { x: 0, y: 0, ...BOUNDS };
  expect(namePlace([long, short], at, BOUNDS, [whole])).toEqual({
    name: short,
    box: { x: 60, y: 5, width: 60, height: 15 },
  });
});

test("a name wider than the strip begins at its edge", () => {
  const wide = { width: 300, height: 15 };
  expect(namePlace([wide], { x: 90, bottom: 20 }, BOUNDS, []).box.x).toBe(1);
});
