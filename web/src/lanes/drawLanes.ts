/** Draws the lanes: intensity as a light line with points, desired utility red, relative message rate blue. */

import type { RobotEvent } from "../protocol/types";
import { Columns, type Span, toColumns } from "./columns";
import type { Lane, LaneHistory } from "./history";
import { spells } from "./runLengths";
import { tickStep } from "./viewport";

export const COLORS = {
  intensity: "#f1f5fb",
  utility: "#ff6464",
  rate: "#2f62b3", // opaque: overlapping columns must not show
  band: "#1d2530",
  grid: "#27303d",
  axis: "#a3b1c2",
  mark: "#e5c07b",
  done: "#52d18c",
  failed: "#ff6464",
  cursor: "#e9eef5",
  unfulfilled: "#ff6464",
  degraded: "#52d18c",
};
export const AXIS_PX = 20;
const PAD_PX = 4;

export interface Scene {
  history: LaneHistory;
  classes: readonly string[];
  marks: readonly RobotEvent[];
  from: number;
  to: number;
  /** Greatest intensity or utility; the relative rate is scaled to it. */
  scale: number;
  /** CSS pixels. */
  width: number;
  rowHeight: number;
  ratio: number;
  /** What the right edge is called. */
  edge: string;
  cursor: { stamp: number; row: number } | null;
}

export class LanePainter {
  private columns = new Columns(0);

  constructor(private readonly context: CanvasRenderingContext2D) {}

  paint(scene: Scene): void {
    const { context: c } = this;
    const { width, ratio, rowHeight, classes } = scene;
    if (this.columns.x.length < width * ratio) this.columns = new Columns(width * ratio);
    const height = classes.length * rowHeight;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height + AXIS_PX);
    this.axis(scene, height);
    classes.forEach((name, row) => {
      const lane = scene.history.lanes.get(name);
      const top = row * rowHeight;
      if (lane) this.lane(scene, lane, top);
      c.fillStyle = COLORS.grid;
      c.fillRect(0, top + rowHeight - 1, width, 1);
    });
    this.marks(scene, height);
    if (scene.cursor) this.cursor(scene, height);
  }

  private axis(scene: Scene, height: number): void {
    const { context: c } = this;
    const span = scene.to - scene.from;
    const every = tickStep(span, Math.max(2, Math.floor(scene.width / 70)));
    c.font = "11px system-ui, sans-serif";
    c.textBaseline = "middle";
    for (let s = 0; s <= span; s += every) {
      const x = scene.width * (1 - s / span);
      c.fillStyle = COLORS.band;
      c.fillRect(Math.round(x) - 1, 0, 1, height);
      c.fillStyle = COLORS.axis;
      const label = s === 0 ? scene.edge : every >= 60 ? `−${s / 60} min` : `−${s} s`;
      const half = c.measureText(label).width / 2;
      if (x - half < 0) continue;
      c.fillText(label, Math.min(x - half, scene.width - half * 2 - 1), height + AXIS_PX / 2 + 1);
    }
  }

  private lane(scene: Scene, lane: Lane, top: number): void {
    const { context: c, columns } = this;
    const { history, ratio, rowHeight, scale } = scene;
    const span: Span = { from: scene.from, to: scene.to, width: scene.width * ratio };
    const floor = top + rowHeight - PAD_PX;
    const unit = (rowHeight - 2 * PAD_PX) / scale;

    toColumns(history, lane.divisor, span, columns);
    this.foot(columns, ratio, floor);
    toColumns(history, lane.rate, span, columns);
    this.bars(columns, ratio, floor, unit * scale);
    toColumns(history, lane.utility, span, columns);
    this.line(columns, ratio, floor, unit, COLORS.utility, 3);
    toColumns(history, lane.intensity, span, columns);
    this.line(columns, ratio, floor, unit, COLORS.intensity, 1.5);
    this.points(columns, ratio, floor, unit);
    this.ribbon(history, lane, span, ratio, top + rowHeight - 3);
    c.globalAlpha = 1;
  }

  /** A thin foot while the lane is open: open and nothing offered is not closed. */
  private foot(columns: Columns, ratio: number, floor: number): void {
    const { context: c } = this;
    c.fillStyle = COLORS.rate;
    for (let i = 0; i < columns.length; i++) {
      const left = columns.x[i]! / ratio;
      c.fillRect(left, floor - 2, columns.end[i]! / ratio - left, 2);
    }
  }

  private bars(columns: Columns, ratio: number, floor: number, reach: number): void {
    const { context: c } = this;
    c.fillStyle = COLORS.rate;
    for (let i = 0; i < columns.length; ) {
      const mean = columns.mean[i]!;
      let j = i;
      while (j + 1 < columns.length && columns.mean[j + 1] === mean && columns.x[j + 1]! - columns.end[j]! < 1) j++;
      const left = columns.x[i]! / ratio;
      const wide = Math.max(columns.end[j]! - columns.x[i]!, 1) / ratio;
      if (mean > 0) c.fillRect(left, floor - mean * reach, wide, mean * reach);
      i = j + 1;
    }
  }

  private line(columns: Columns, ratio: number, floor: number, unit: number, color: string, wide: number): void {
    const { context: c } = this;
    c.strokeStyle = color;
    c.lineWidth = wide;
    c.lineJoin = "round";
    c.beginPath();
    for (let i = 0; i < columns.length; i++) {
      const x = columns.x[i]! / ratio;
      const y = floor - columns.last[i]! * unit;
      if (i > 0 && columns.x[i]! - columns.end[i - 1]! < 1.5) c.lineTo(x, y);
      else c.moveTo(x, y);
      if (columns.low[i] !== columns.high[i]) {
        c.moveTo(x, floor - columns.low[i]! * unit);
        c.lineTo(x, floor - columns.high[i]! * unit);
        c.moveTo(x, y);
      }
      c.lineTo(columns.end[i]! / ratio, y);
    }
    c.stroke();
  }

  /** A point where the intensity begins or changes. */
  private points(columns: Columns, ratio: number, floor: number, unit: number): void {
    const { context: c } = this;
    c.fillStyle = COLORS.intensity;
    c.beginPath();
    for (let i = 0; i < columns.length; i++) {
      const begins =
        i === 0
          ? columns.x[0]! > 0
          : columns.x[i]! - columns.end[i - 1]! >= 1.5 || columns.last[i] !== columns.last[i - 1];
      if (!begins) continue;
      const x = columns.x[i]! / ratio;
      const y = floor - columns.last[i]! * unit;
      c.moveTo(x + 2.6, y);
      c.arc(x, y, 2.6, 0, 2 * Math.PI);
    }
    c.fill();
  }

  /** Along the foot of the lane: red while its desire is not fulfilled, green while it is, but below its best. */
  private ribbon(history: LaneHistory, lane: Lane, span: Span, ratio: number, top: number): void {
    const { context: c } = this;
    const perSecond = span.width / ratio / (span.to - span.from);
    spells(history, lane, span, (state, from, to) => {
      if (state !== "unfulfilled" && state !== "degraded") return;
      const left = Math.max(0, (from - span.from) * perSecond);
      c.fillStyle = COLORS[state];
      c.fillRect(left, top, Math.max(1, (to - span.from) * perSecond - left), 2);
    });
  }

  private marks(scene: Scene, height: number): void {
    const { context: c } = this;
    const perSecond = scene.width / (scene.to - scene.from);
    for (const event of scene.marks) {
      const x = (event.stamp - scene.from) * perSecond;
      const row = markRow(event, scene.classes);
      if (event.kind === "accomplishment") {
        if (row >= 0) this.accomplishment(event, x, (row + 1) * scene.rowHeight - 1);
        continue;
      }
      c.fillStyle = COLORS.mark;
      const top = row < 0 ? 0 : row * scene.rowHeight;
      if (row >= 0 || event.kind === "intention") {
        c.globalAlpha = row < 0 ? 0.3 : 0.8;
        c.fillRect(Math.round(x), top, 1, row < 0 ? height : scene.rowHeight - 1);
        c.globalAlpha = 1;
        if (row < 0) continue;
      }
      c.beginPath();
      c.moveTo(x - 4, top);
      c.lineTo(x + 5, top);
      c.lineTo(x + 0.5, top + 6);
      c.fill();
    }
  }

  /** At the foot of its lane: at the head, the end of the desire has its mark at the same moment. */
  private accomplishment(event: RobotEvent, x: number, foot: number): void {
    const { context: c } = this;
    c.fillStyle = COLORS[event.data["outcome"] === "failed" ? "failed" : "done"];
    c.beginPath();
    c.moveTo(x - 4, foot);
    c.lineTo(x + 5, foot);
    c.lineTo(x + 0.5, foot - 6);
    c.fill();
    c.font = "600 9px system-ui, sans-serif";
    c.textAlign = "left";
    c.textBaseline = "bottom";
    c.fillText("ACC", x + 7, foot + 1);
  }

  private cursor(scene: Scene, height: number): void {
    const { context: c } = this;
    const { stamp, row } = scene.cursor!;
    const x = ((stamp - scene.from) / (scene.to - scene.from)) * scene.width;
    c.fillStyle = COLORS.cursor;
    c.globalAlpha = 0.06;
    c.fillRect(0, row * scene.rowHeight, scene.width, scene.rowHeight);
    c.globalAlpha = 0.7;
    c.fillRect(Math.round(x), 0, 1, height);
    c.globalAlpha = 1;
  }
}

/** Which lane an event belongs to; −1: none of them, it concerns all. */
export function markRow(event: RobotEvent, classes: readonly string[]): number {
  const named = event.data && typeof event.data["class"] === "string" ? event.data["class"] : event.subject;
  return named ? classes.indexOf(named) : -1;
}
