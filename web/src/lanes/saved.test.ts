import { expect, test } from "vitest";
import type { LaneRow } from "../protocol/types";
import { LaneHistory } from "./history";
import { lanesCsv, lanesSvg } from "./saved";

const START = 1_790_000_000;

function history(): LaneHistory {
  const made = new LaneHistory();
  for (let i = 0; i < 40; i++) {
    const row = { class: "FindQRCodes", intensity: i < 20 ? 8 : 2, utility: 1, rate: 0.5, divisor: 2 };
    made.push({
      stamp: START + i / 10,
      rows: [{ ...row, divisors: {}, state: i < 20 ? "fulfilled" : "unfulfilled", text: 'no "room"' } as LaneRow],
    });
  }
  return made;
}
const edges = { from: START, to: START + 4 };

test("the table has one line for each change, and reasons are quoted", () => {
  expect(lanesCsv(history(), ["FindQRCodes", "Unknown"], edges).trimEnd().split("\n")).toEqual([
    "time_s,class,intensity,utility,phi,measured_rate,state,reason",
    `${START}.000,FindQRCodes,8,1,2,0.5,fulfilled,"no ""room"""`,
    `${START + 2}.000,FindQRCodes,2,1,2,0.5,unfulfilled,"no ""room"""`,
  ]);
});

test("the drawing has a point per change of the intensity, and half the height for half of the messages", () => {
  const svg = lanesSvg(history(), ["FindQRCodes"], edges, 8);
  expect(svg.match(/<circle /g)).toHaveLength(2);
  expect(svg).toContain('cx="150" cy="8"');
  expect(svg).toContain('<rect x="150" y="37" width="760" height="29"');
  expect(svg).toContain(">Find QR codes<");
  expect(svg).toContain("since 2026-09-21 14:13:20 UTC");
});
