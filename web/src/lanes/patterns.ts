/** The patterns by which states and dashes differ without colour. They stand still on the strip: anchored to column 0. */

import type { Palette } from "./palette";

export type Pattern =
  | "dashes"
  | "budget"
  | "exploited"
  | "fulfilled"
  | "degraded"
  | "unfulfilled"
  | "inhibited"
  | "needed";

/** Columns after which a pattern repeats, in CSS pixels. */
export const PERIOD = 12;
/** Rows of a tile, in CSS pixels: patterns are no higher. */
const HIGH = 6;

type Cell = [x: number, y: number, wide: number, high: number];

/** Filled cells of one tile, in CSS pixels: the height is that of the band. */
function cells(pattern: Pattern, high: number): Cell[] {
  const lower = Math.max(1.5, high / 3);
  switch (pattern) {
    case "dashes":
      return [[0, 0, 8, high]];
    case "budget":
      return [
        [0, 0, 4, high],
        [6, 0, 4, high],
      ];
    case "exploited":
      return [[0, 0, PERIOD, high]];
    case "fulfilled":
      return [[0, high - lower, PERIOD, lower]];
    case "degraded":
      return [
        [0, high - lower, 4, lower],
        [6, high - lower, 4, lower],
      ];
    case "needed":
      return [0, 4, 8].map((x): Cell => [x, high - lower, lower, lower]);
    case "inhibited":
      return [0, 3, 6, 9].map((x): Cell => [x, 0, 1.5, high]);
    case "unfulfilled":
      // Slanted: one cell per row, moved on by one.
      return [0, 6].flatMap((x) => Array.from({ length: Math.ceil(high) }, (_, y): Cell => [x + y, y, 3, 1]));
  }
}

export class Patterns {
  private readonly made = new Map<string, CanvasPattern>();

  constructor(
    private readonly context: CanvasRenderingContext2D,
    private readonly palette: Palette,
    private readonly ratio: number,
  ) {}

  /** Fills a rectangle, in device pixels. */
  fill(pattern: Pattern, x: number, y: number, wide: number, high: number): void {
    const { context: c } = this;
    if (wide <= 0) return;
    c.save();
    c.translate(0, y);
    c.fillStyle = this.pattern(pattern, Math.round(high));
    c.fillRect(x, 0, wide, high);
    c.restore();
  }

  private pattern(pattern: Pattern, high: number): CanvasPattern {
    const key = `${pattern} ${high}`;
    const known = this.made.get(key);
    if (known) return known;
    const tile = document.createElement("canvas");
    tile.width = Math.round(PERIOD * this.ratio);
    tile.height = Math.max(high, Math.round(HIGH * this.ratio));
    const t = tile.getContext("2d")!;
    t.scale(this.ratio, this.ratio);
    t.fillStyle = this.color(pattern);
    for (const [x, y, wide, tall] of cells(pattern, high / this.ratio)) {
      t.fillRect(x, y, wide, tall);
      // What is cut off at the right goes on at the left.
      if (x + wide > PERIOD) t.fillRect(x - PERIOD, y, wide, tall);
    }
    const made = this.context.createPattern(tile, "repeat")!;
    this.made.set(key, made);
    return made;
  }

  private color(pattern: Pattern): string {
    const { palette: p } = this;
    if (pattern === "dashes") return p.utility;
    if (pattern === "budget") return p.mark;
    if (pattern === "unfulfilled" || pattern === "inhibited" || pattern === "needed") return p[pattern];
    return p.intended;
  }
}
