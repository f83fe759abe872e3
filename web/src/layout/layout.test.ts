import { expect, test } from "vitest";
import { DEFAULTS, decode, encode, LANES_SHARES, limited, PRESETS, SIDE_SHARES } from "./layout";

test("a link carries a layout there and back", () => {
  for (const preset of PRESETS)
    for (const edge of ["left", "right"] as const)
      for (const sideShown of [true, false])
        for (const lanesShown of [true, false])
          for (const lanesAt of ["bottom", "top"] as const) {
            const chosen = { preset, layout: { ...DEFAULTS[preset], edge, sideShown, lanesShown, lanesAt } };
            expect(decode(encode(chosen))).toEqual(chosen);
          }
});

test.each([
  null,
  "",
  "attention",
  "attention-28-33-sl",
  "nonsense-28-33-sl-r",
  "drive-28-33-q-r",
  "drive--5-33-s-r",
  "drive-28-33-s-t",
])("%s is no layout", (text) => {
  expect(decode(text)).toBeNull();
});

test("no share takes all the room or leaves none", () => {
  const layout = decode("drive-99-0-sl-r")!.layout;
  expect(layout.side).toBe(SIDE_SHARES.most);
  expect(layout.lanes).toBe(LANES_SHARES.least);
  expect(limited(layout)).toEqual(layout);
});
