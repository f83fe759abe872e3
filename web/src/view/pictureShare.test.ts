import { expect, test } from "vitest";
import { pictureShare } from "./pictureShare";

const PICTURE = { width: 640, height: 480 };

test("a picture of the box's shape fills it", () => {
  expect(pictureShare({ width: 320, height: 240 }, PICTURE, 80, 60)).toEqual({ u: 0.25, v: 0.25 });
});

test("in a wider or a higher box it is in the middle, and beside it is beyond 0 to 1", () => {
  const wide = { width: 1000, height: 480 };
  expect(pictureShare(wide, PICTURE, 500, 240)).toEqual({ u: 0.5, v: 0.5 });
  expect(pictureShare(wide, PICTURE, 180, 0)).toEqual({ u: 0, v: 0 });
  expect(pictureShare(wide, PICTURE, 100, 0).u).toBeLessThan(0);
  expect(pictureShare({ width: 640, height: 880 }, PICTURE, 640, 680)).toEqual({ u: 1, v: 1 });
});
