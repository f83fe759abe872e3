/**
 * Draws the lanes: 1/φ as a step with its edge, the measured rate a thin line on it, desired utility dashed, intensity as a
 * line with points; along the foot of each what became of the desire, by pattern and colour.
 */

import type { LaneState, RobotEvent } from "../protocol/types";
import { Columns, type Span, toColumns } from "./columns";
import type { Lane, LaneHistory } from "./history";
import type { Palette } from "./palette";
import { type Pattern, Patterns } from "./patterns";
import { spells } from "./runLengths";
import type { Slice, Strip } from "./strip";
import type { IntentionStep, Spell } from "./timelineOf";

/** Columns drawn again at the left of a slice: what belongs to an instant reaches a little to both of its sides. */
const LAP_PX = 6;
/** Columns looked at before those: what held there, and the marks with words that reach this far to the right. */
const BEFORE_PX = 44;
export const GAUGE_PX = 24;
/** Values drawn at least so high have room for thicker lines. */
const ROOMY_PX = 18;

/** Ω, or a resource of a budget: a lane of its own below the others. */
export interface Gauge {
  name: string;
  title: string;
  figure: string;
  /** The top of the lane. */
  most: number;
  /** What is promised at most; null: no budget. */
  budget: number | null;
  value: (step: IntentionStep) => number;
}

export interface Scene {
  history: LaneHistory;
  classes: readonly string[];
  marks: readonly RobotEvent[];
  exploited: ReadonlyMap<string, readonly Spell[]>;
  steps: readonly IntentionStep[];
  gauges: readonly Gauge[];
  strip: Strip;
  /** Greatest intensity or utility; the relative rate is scaled to it. */
  scale: number;
  /** CSS pixels. */
  rowHeight: number;
  ratio: number;
  palette: Palette;
  /** What was before the oldest of `history`. */
  past: LaneHistory | null;
}

/** Part of the strip with what is next to it, in device pixels. */
interface Part {
  span: Span;
  /** Left edge of `span`. */
  left: number;
}

/** Heights of a row, from its top: where values are drawn, and the foot with the states. */
export function rowLayout(rowHeight: number): { top: number; floor: number; foot: number; footHigh: number } {
  const roomy = rowHeight >= 30;
  const footHigh = roomy ? 6 : 4;
  const foot = rowHeight - 1 - footHigh;
  return { top: 4, floor: foot - (roomy ? 3 : 2), foot, footHigh };
}

export class LanePainter {
  private columns = new Columns(0);
  private patterns: Patterns | null = null;
  private ratio = 1;
  private palette: Palette | null = null;

  constructor(private readonly context: CanvasRenderingContext2D) {}

  /** Draws the columns of `slice`, and nothing beside them but what they change on their left. */
  paint(scene: Scene, slice: Slice): void {
    const { context: c } = this;
    const { ratio, rowHeight, classes, strip } = scene;
    const { height } = c.canvas;
    const [clip, first] = [LAP_PX, BEFORE_PX].map((by) => Math.max(0, slice.from - Math.ceil(by * ratio)));
    const wide = slice.to - first!;
    if (this.columns.x.length < wide + 4) this.columns = new Columns(strip.columns);
    if (ratio !== this.ratio || scene.palette !== this.palette || !this.patterns)
      this.patterns = new Patterns(c, scene.palette, ratio);
    this.ratio = ratio;
    this.palette = scene.palette;
    c.setTransform(1, 0, 0, 1, 0, 0);
    if (slice.whole) c.clearRect(0, 0, strip.columns, height);
    if (slice.to <= slice.from) return;
    c.save();
    c.beginPath();
    c.rect(clip!, 0, slice.to - clip!, height);
    c.clip();
    c.clearRect(clip!, 0, slice.to - clip!, height);
    const span = { from: strip.stamp(first!), to: strip.stamp(slice.to), width: wide };
    const part = { span, left: first! };
    for (const [history, piece] of pieces(scene, part))
      classes.forEach((name, row) => this.lane({ ...scene, history }, piece, name, row * rowHeight * ratio));
    const below = classes.length * rowHeight;
    scene.gauges.forEach((gauge, i) => this.gauge(scene, part, gauge, (below + i * GAUGE_PX) * ratio));
    this.marks(scene, part);
    c.restore();
  }

  private lane(scene: Scene, part: Part, name: string, y: number): void {
    const { context: c, columns, ratio } = this;
    const { history, rowHeight, scale, palette } = scene;
    const at = rowLayout(rowHeight);
    const [top, floor] = [y + at.top * ratio, y + at.floor * ratio];
    const high = floor - top;
    c.fillStyle = palette.scale;
    for (const line of [top, top + high / 2]) c.fillRect(part.left, Math.round(line), part.span.width, 1);
    c.fillStyle = palette.foot;
    c.fillRect(part.left, y + rowHeight * ratio - 1, part.span.width, 1);
    const lane = history.lanes.get(name);
    if (!lane) return;
    c.translate(part.left, 0);
    toColumns(history, lane.divisor, part.span, columns);
    this.openness(columns, floor, high, palette);
    toColumns(history, lane.rate, part.span, columns, lane);
    this.line(floor, high, palette.measured, ratio, true);
    c.translate(-part.left, 0);
    toColumns(history, lane.utility, part.span, columns);
    this.utility(part.left, floor, high, scale, palette.utility);
    c.translate(part.left, 0);
    toColumns(history, lane.intensity, part.span, columns);
    this.line(floor, high / scale, palette.intensity, 1.6 * ratio);
    this.points(floor, high / scale, palette.intensity);
    c.translate(-part.left, 0);
    this.states(scene, part, lane, name, y + at.foot * ratio, at.footHigh * ratio);
  }

  /** 1/φ: a step at the instant that φ changes. */
  private openness(columns: Columns, floor: number, high: number, palette: Palette): void {
    const { context: c, ratio } = this;
    for (let i = 0; i < columns.length; ) {
      const phi = columns.last[i]!;
      let j = i;
      while (j + 1 < columns.length && columns.last[j + 1] === phi && columns.x[j + 1]! - columns.end[j]! < 1.5) j++;
      const [left, wide] = [columns.x[i]!, Math.max(columns.end[j]! - columns.x[i]!, 1)];
      const y = floor - high / phi;
      c.fillStyle = palette.rate;
      c.fillRect(left, y, wide, floor - y);
      c.fillStyle = palette.edge;
      c.fillRect(left, y - ratio / 2, wide, 1.5 * ratio);
      i = j + 1;
    }
  }

  /** Dashes, so that a line at the same height hides no more than their middle; a bracket where it begins or changes. */
  private utility(left: number, floor: number, high: number, scale: number, color: string): void {
    const { context: c, ratio, columns } = this;
    const unit = high / scale;
    const thick = Math.round((high >= ROOMY_PX * ratio ? 5 : 4) * ratio);
    for (let i = 0; i < columns.length; i++) {
      const y = floor - columns.last[i]! * unit;
      const x = left + columns.x[i]!;
      this.patterns!.fill("dashes", x, y - thick / 2, left + columns.end[i]! - x, thick);
      const begins = i === 0 ? columns.x[0]! > 0 : changes(columns, i);
      if (!begins) continue;
      c.fillStyle = color;
      c.fillRect(x, y - thick / 2, 2.5 * ratio, Math.min(9 * ratio, floor - y + thick / 2));
    }
  }

  /** With `passing`, only where it is over 0: what is closed has no rate. */
  private line(floor: number, unit: number, color: string, wide: number, passing = false): void {
    const { context: c, columns } = this;
    c.strokeStyle = color;
    c.lineWidth = wide;
    c.lineJoin = "round";
    c.beginPath();
    for (let i = 0; i < columns.length; i++) {
      if (passing && columns.high[i] === 0) continue;
      const x = columns.x[i]!;
      const y = floor - columns.last[i]! * unit;
      if (i > 0 && x - columns.end[i - 1]! < 1.5 && !(passing && columns.high[i - 1] === 0)) c.lineTo(x, y);
      else c.moveTo(x, y);
      if (columns.low[i] !== columns.high[i]) {
        c.moveTo(x, floor - columns.low[i]! * unit);
        c.lineTo(x, floor - columns.high[i]! * unit);
        c.moveTo(x, y);
      }
      c.lineTo(columns.end[i]!, y);
    }
    c.stroke();
  }

  /** A point where the intensity begins or changes. */
  private points(floor: number, unit: number, color: string): void {
    const { context: c, ratio, columns } = this;
    c.fillStyle = color;
    c.beginPath();
    for (let i = 0; i < columns.length; i++) {
      if (i === 0 ? columns.x[0] === 0 : !changes(columns, i)) continue;
      const [x, y] = [columns.x[i]!, floor - columns.last[i]! * unit];
      c.moveTo(x + 2.8 * ratio, y);
      c.arc(x, y, 2.8 * ratio, 0, 2 * Math.PI);
    }
    c.fill();
  }

  private states(scene: Scene, part: Part, lane: Lane, name: string, y: number, high: number): void {
    const { span } = part;
    const { perSecond } = scene.strip;
    const band = (pattern: Pattern, from: number, to: number) => {
      const left = Math.round((Math.max(from, span.from) - span.from) * perSecond);
      const right = Math.round((Math.min(to, span.to) - span.from) * perSecond);
      if (right >= 0) this.patterns!.fill(pattern, part.left + left, y, Math.max(1, right - left), high);
    };
    spells(scene.history, lane, span, (state, from, to) => {
      const pattern = PATTERN_OF[state];
      if (pattern) band(pattern, from, to);
    });
    for (const { from, to } of scene.exploited.get(name) ?? [])
      if (to > span.from && from < span.to) band("exploited", from, Math.min(to, span.to));
  }

  /** Ω or what is promised of a resource: an area with its edge, and the budget as a line. */
  private gauge(scene: Scene, part: Part, gauge: Gauge, y: number): void {
    const { context: c, ratio } = this;
    const { strip, steps, palette } = scene;
    const [top, floor] = [y + 4 * ratio, y + (GAUGE_PX - 3) * ratio];
    c.fillStyle = palette.foot;
    c.fillRect(part.left, y + GAUGE_PX * ratio - 1, part.span.width, 1);
    steps.forEach((step, i) => {
      const until = steps[i + 1]?.stamp ?? Infinity;
      if (until <= part.span.from || step.stamp >= part.span.to) return;
      const left = strip.column(Math.max(step.stamp, part.span.from));
      const wide = strip.column(Math.min(until, part.span.to)) - left;
      const high = (floor - top) * Math.min(1, gauge.value(step) / gauge.most);
      c.fillStyle = palette.rate;
      c.fillRect(left, floor - high, wide, high);
      c.fillStyle = palette.edge;
      c.fillRect(left, floor - high - ratio / 2, wide, 1.5 * ratio);
    });
    if (gauge.budget === null) return;
    const line = floor - (floor - top) * Math.min(1, gauge.budget / gauge.most);
    this.patterns!.fill("budget", part.left, line, part.span.width, 1.5 * ratio);
  }

  private marks(scene: Scene, part: Part): void {
    const { context: c, ratio } = this;
    const palette = scene.palette;
    const reach = (LAP_PX * ratio) / scene.strip.perSecond;
    const high = (scene.classes.length * scene.rowHeight + scene.gauges.length * GAUGE_PX) * ratio;
    for (const event of scene.marks) {
      if (event.stamp < part.span.from - reach || event.stamp > part.span.to + reach) continue;
      const x = Math.round(scene.strip.column(event.stamp));
      const row = markRow(event, scene.classes);
      if (event.kind === "intention") {
        c.fillStyle = palette.mark;
        c.globalAlpha = 0.28;
        c.fillRect(x, 0, ratio, high);
        c.globalAlpha = 1;
      }
      if (row < 0) continue;
      const top = row * scene.rowHeight * ratio;
      if (event.kind === "accomplishment") this.accomplishment(event, x, top + (scene.rowHeight - 1) * ratio, palette);
      else {
        c.fillStyle = palette.mark;
        c.globalAlpha = 0.8;
        c.fillRect(x, top, ratio, (scene.rowHeight - 1) * ratio);
        c.globalAlpha = 1;
        this.triangle(x + ratio / 2, top, 6 * ratio);
      }
    }
  }

  /** At the foot of its lane: at the head, the end of the desire has its mark at the same moment. */
  private accomplishment(event: RobotEvent, x: number, foot: number, palette: Palette): void {
    const { context: c, ratio } = this;
    c.fillStyle = event.data["outcome"] === "failed" ? palette.unfulfilled : palette.intended;
    this.triangle(x, foot, -6 * ratio);
    c.font = `600 ${9 * ratio}px system-ui, sans-serif`;
    c.textAlign = "left";
    c.textBaseline = "bottom";
    c.fillText("ACC", x + 7 * ratio, foot + ratio);
  }

  private triangle(x: number, y: number, high: number): void {
    const { context: c, ratio } = this;
    c.beginPath();
    c.moveTo(x - 4.5 * ratio, y);
    c.lineTo(x + 4.5 * ratio, y);
    c.lineTo(x, y + high);
    c.fill();
  }
}

const PATTERN_OF: Partial<Record<LaneState, Pattern>> = {
  fulfilled: "fulfilled",
  degraded: "degraded",
  unfulfilled: "unfulfilled",
  inhibited: "inhibited",
  needed: "needed",
};

/** `part` at the column where what was heard begins: the past before it, and what was heard. */
function pieces({ history, past, strip }: Scene, part: Part): [LaneHistory, Part][] {
  if (!past || past.count === 0) return [[history, part]];
  const right = part.left + part.span.width;
  const column = history.count > 0 ? Math.round(strip.column(history.oldest)) : right;
  const seam = Math.max(part.left, Math.min(right, column));
  const piece = (left: number, to: number): Part => ({
    span: { from: strip.stamp(left), to: strip.stamp(to), width: to - left },
    left,
  });
  const found: [LaneHistory, Part][] = [];
  if (seam > part.left) found.push([past, piece(part.left, seam)]);
  if (seam < right) found.push([history, piece(seam, right)]);
  return found;
}

/** Whether what column `i` shows is not what the one before it showed to its end. */
function changes(columns: Columns, i: number): boolean {
  return columns.x[i]! - columns.end[i - 1]! >= 1.5 || columns.last[i] !== columns.last[i - 1];
}

/** Which lane an event belongs to; −1: none of them, it concerns all. */
export function markRow(event: RobotEvent, classes: readonly string[]): number {
  const named = event.data && typeof event.data["class"] === "string" ? event.data["class"] : event.subject;
  return named ? classes.indexOf(named) : -1;
}
