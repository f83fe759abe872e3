/** Draws the events that belong to no lane: folded, with words where there is room for them. */

import type { RobotEvent } from "../protocol/types";
import type { Palette } from "./palette";
import type { Strip } from "./strip";
import { folded, foldedWords } from "./timelineOf";

export const EVENTS_PX = 18;
/** Repeats nearer than this (CSS pixels) are one mark. */
export const FOLD_PX = 60;
const MARK_PX = 12;
const GAP_PX = 8;

export function drawEvents(
  c: CanvasRenderingContext2D,
  events: readonly RobotEvent[],
  strip: Strip,
  { ratio, palette }: { ratio: number; palette: Palette },
): void {
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, strip.columns / ratio, EVENTS_PX);
  c.font = "11px system-ui, sans-serif";
  c.textBaseline = "middle";
  const marks = folded(events, (FOLD_PX * ratio) / strip.perSecond);
  const x = (stamp: number) => strip.column(stamp) / ratio;
  marks.forEach((mark, i) => {
    const [from, to] = [x(mark.from), x(mark.to)];
    const next = marks[i + 1] ? x(marks[i + 1]!.from) : Infinity;
    c.fillStyle = palette.mark;
    c.globalAlpha = 0.45;
    if (to > from) c.fillRect(from, 3, to - from, 2);
    c.globalAlpha = 1;
    c.beginPath();
    c.moveTo(from - 4.5, 3);
    c.lineTo(from + 4.5, 3);
    c.lineTo(from, 10);
    c.fill();
    const words = foldedWords(mark);
    if (from + MARK_PX + c.measureText(words).width + GAP_PX > next) return;
    c.fillStyle = palette.words;
    c.fillText(words, from + MARK_PX - 4, 10);
  });
}
