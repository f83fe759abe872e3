/** The living canvas of the lanes: size, clock and viewport in, a frame out whenever it would look different. */

import type { RobotEvent } from "../protocol/types";
import type { Store } from "../state/store";
import { clockSpan, clockTime } from "../ui/format";
import { AXIS_PX, LanePainter, markRow } from "./drawLanes";
import type { LaneSample } from "./history";
import { edges, INITIAL, TRAIL_S, type Viewport } from "./viewport";

/** Kinds of events that are marked: what changes the attention, and what disturbs it. */
const MARKED = new Set(["desire", "accomplishment", "intention", "overload", "module", "restart", "stale"]);
const NEAR_PX = 7;

export interface Hit {
  row: number;
  name: string;
  stamp: number;
  sample: LaneSample | null;
  events: RobotEvent[];
  /** CSS pixels within the chart. */
  x: number;
  y: number;
  height: number;
}

export class LaneChart {
  view: Viewport = INITIAL;
  /** Where the pointer or the keyboard is: share of the width, row. */
  cursor: { share: number; row: number } | null = null;
  rowHeight = 32;
  private readonly painter: LanePainter;
  private width = 0;
  private drawn = "";
  private marks: RobotEvent[] = [];
  private marksOf: RobotEvent[] | null = null;
  /** Since `since`: animation frames, frames painted, and milliseconds spent painting them. */
  private cost = { since: performance.now(), frames: 0, painted: 0, ms: 0 };

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly store: Store,
    private readonly classes: () => readonly string[],
  ) {
    this.painter = new LanePainter(canvas.getContext("2d", { alpha: true })!);
  }

  get history() {
    return this.store.lanes;
  }

  get rows(): number {
    return this.classes().length;
  }

  now(): number {
    return this.store.clock.now(performance.now() / 1000) ?? this.store.lanes.newest ?? 0;
  }

  /** Nothing arrives late in a recording that stands; in one that runs fast, more of it is under way. */
  private trail(): number {
    return this.store.replay.peek() ? TRAIL_S * this.store.clock.rate : TRAIL_S;
  }

  resize(width: number, rowHeight: number): void {
    this.width = Math.max(1, Math.floor(width));
    this.rowHeight = rowHeight;
    this.drawn = "";
  }

  /** Called each animation frame; paints only when half a device pixel or anything else has changed. */
  frame(): void {
    this.writeFigures();
    const classes = this.classes();
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    if (this.width < 2 || classes.length === 0) return;
    const { from, to } = edges(this.view, this.now(), this.trail());
    const perSecond = (this.width * ratio) / (to - from);
    const events = this.store.events.value;
    const key = `${Math.round(to * perSecond * 2)} ${this.view.windowS} ${this.width} ${this.rowHeight} ${ratio} ${classes.length} ${events.length} ${this.cursor?.share} ${this.cursor?.row}`;
    if (key === this.drawn) return;
    this.drawn = key;
    this.fit(ratio, classes.length);
    if (this.marksOf !== events) {
      this.marksOf = events;
      this.marks = events.filter((event) => MARKED.has(event.kind));
    }
    const began = performance.now();
    this.painter.paint({
      history: this.store.lanes,
      classes,
      marks: this.marks.filter((event) => event.stamp >= from && event.stamp <= to),
      from,
      to,
      scale: Math.max(1, this.store.hello.value?.scale.intensity ?? 8),
      width: this.width,
      rowHeight: this.rowHeight,
      ratio,
      edge: this.edgeWord(to),
      cursor: this.cursor && { stamp: from + (to - from) * this.cursor.share, row: this.cursor.row },
    });
    this.cost.painted += 1;
    this.cost.ms += performance.now() - began;
  }

  /** What the right edge is called: a recording has no present. */
  private edgeWord(to: number): string {
    const playback = this.store.playback.peek();
    return playback ? clockSpan(to - playback.begin) : this.view.heldAt === null ? "now" : clockTime(to);
  }

  /** Once a second, writes its figures to the canvas's attributes: for measurements from outside. */
  private writeFigures(): void {
    this.cost.frames += 1;
    const { since, frames, painted, ms } = this.cost;
    const seconds = (performance.now() - since) / 1000;
    if (seconds < 1) return;
    this.canvas.dataset["newest"] = String(this.store.lanes.newest ?? "");
    this.canvas.dataset["fps"] = (frames / seconds).toFixed(1);
    this.canvas.dataset["painted"] = (painted / seconds).toFixed(1);
    this.canvas.dataset["paintMs"] = (ms / Math.max(1, painted)).toFixed(2);
    this.cost = { since: performance.now(), frames: 0, painted: 0, ms: 0 };
  }

  /** What is under the cursor. */
  hit(): Hit | null {
    const classes = this.classes();
    if (!this.cursor || classes.length === 0) return null;
    const row = Math.max(0, Math.min(classes.length - 1, this.cursor.row));
    const name = classes[row]!;
    const { from, to } = edges(this.view, this.now(), this.trail());
    const stamp = from + (to - from) * this.cursor.share;
    const near = (NEAR_PX / this.width) * (to - from);
    const events = this.marks.filter((event) => {
      const place = markRow(event, classes);
      return Math.abs(event.stamp - stamp) <= near && (place < 0 || place === row);
    });
    const sample = this.store.lanes.sample(name, stamp);
    const height = this.rowHeight;
    return { row, name, stamp, sample, events, x: this.cursor.share * this.width, y: row * height, height };
  }

  private fit(ratio: number, rows: number): void {
    const height = rows * this.rowHeight + AXIS_PX;
    const [wide, high] = [Math.round(this.width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== wide || this.canvas.height !== high) {
      this.canvas.width = wide;
      this.canvas.height = high;
      this.canvas.style.width = `${this.width}px`;
      this.canvas.style.height = `${height}px`;
    }
  }
}
