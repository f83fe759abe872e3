import { expect, test } from "vitest";
import { isOld, pictureAge, sceneAge } from "./pictureAge";

test("a fresh picture says its age in small steps, and is not late", () => {
  expect(pictureAge(0.123, 1, false)).toMatchObject({ text: "120 ms", late: false });
  expect(pictureAge(0.123, 1, false)?.title).toContain("glass to glass");
  // Two clocks agree to some milliseconds.
  expect(pictureAge(-0.004, 1, false)?.text).toBe("0 ms");
});

test("over half a second it is late, over one old", () => {
  expect(pictureAge(0.5, 1, false)?.late).toBe(false);
  expect(pictureAge(0.51, 1, false)).toMatchObject({ text: "510 ms", late: true });
  expect(isOld(1, 1)).toBe(false);
  expect(pictureAge(2.34, 1, false)).toMatchObject({ text: "2.3 s old", late: true });
});

test("in a recording only what is old says so, at the pace of its clock", () => {
  expect(pictureAge(0.7, 1, true)).toBeNull();
  expect(pictureAge(1.5, 4, true)).toBeNull();
  expect(pictureAge(4.5, 4, true)?.text).toBe("4.5 s old");
});

test("what is no age is not said", () => {
  expect(pictureAge(Number.NaN, 1, false)).toBeNull();
});

test("the 3D view says its age where there is room for few letters, and what it means", () => {
  expect(sceneAge(0.234, 1, false)).toMatchObject({ text: "230 ms", late: false });
  expect(sceneAge(1.26, 1, false)).toMatchObject({ text: "1.3 s", late: true });
  expect(sceneAge(1.26, 1, false)?.title).toMatch(/3D view.*drive slowly/);
  expect(sceneAge(1.26, 4, true)).toBeNull();
});
