import { expect, test } from "vitest";
import { contrast, LIGHT, PAPER, SCREEN, variables } from "./palette";

test.each([
  ["on the screen", SCREEN],
  ["on the screen in light colours", LIGHT],
  ["on paper", PAPER],
])("series and states differ from each other and from their ground, %s", (_, p) => {
  const pairs: [string, string][] = [
    [p.intensity, p.ground],
    [p.intensity, p.rate],
    [p.intensity, p.utility],
    [p.utility, p.rate],
    [p.utility, p.ground],
    [p.edge, p.ground],
    [p.edge, p.rate],
    [p.measured, p.rate],
    [p.measured, p.ground],
    ...[p.intended, p.unfulfilled, p.inhibited, p.needed, p.mark].map((color): [string, string] => [color, p.ground]),
  ];
  for (const [one, other] of pairs) expect(contrast(one, other), `${one} ${other}`).toBeGreaterThanOrEqual(3);
  expect(contrast("#000000", "#ffffff")).toBeCloseTo(21, 5);
});

test("words are readable on their ground", () => {
  for (const p of [SCREEN, LIGHT, PAPER]) {
    expect(contrast(p.words, p.ground)).toBeGreaterThanOrEqual(4.5);
    expect(contrast(p.utilityWords, p.ground)).toBeGreaterThanOrEqual(4.5);
    expect(contrast(p.unfulfilled, p.ground)).toBeGreaterThanOrEqual(4.5);
  }
});

test("style sheets have the same colours", () => {
  expect(variables(LIGHT)).toMatchObject({ "--lane-ground": "#fbfcfe", "--lane-utility": LIGHT.utility });
});
