/** The lanes' canvas: a strip that the compositor moves; four times a second the newest slice of it is drawn. */

import { shownTheme } from "../layout/theme";
import type { Rest } from "../protocol/rest";
import type { RobotEvent } from "../protocol/types";
import type { Store } from "../state/store";
import { accelerated, fourTimesASecond } from "../state/turns";
import { drawEvents, EVENTS_PX, FOLD_PX } from "./drawEvents";
import { GAUGE_PX, type Gauge, LanePainter, markRow } from "./drawLanes";
import type { LaneHistory, LaneSample } from "./history";
import { Mover } from "./mover";
import { LIGHT, SCREEN } from "./palette";
import { joined, Past, wanted } from "./past";
import { PERIOD } from "./patterns";
import { type Edges, Strip } from "./strip";
import {
  exploitedSpells,
  type Folded,
  folded,
  type IntentionStep,
  idleFor,
  intentionAt,
  intentionSteps,
  type Spell,
} from "./timelineOf";
import { edges, INITIAL, LONGEST_S, TRAIL_S, type Viewport } from "./viewport";

/** Kinds of events that are marked: what changes the attention, and what disturbs it. */
const MARKED = new Set([
  "desire",
  "accomplishment",
  "intention",
  "overload",
  "module",
  "restart",
  "stale",
  "capacity",
  "guard",
]);
const NEAR_PX = 7;
/** The row of what belongs to no lane. */
export const EVENTS_ROW = -1;

export interface Hit {
  row: number;
  name: string;
  stamp: number;
  sample: LaneSample | null;
  exploited: boolean;
  /** For how long it had been exploited no more, s, while a strategy was selected for it; null: not so, or not known. */
  idle: number | null;
  /** Of the events' own row: folded. */
  folded: Folded[];
  events: RobotEvent[];
  /** CSS pixels within the chart. */
  x: number;
  y: number;
  height: number;
}

/** What moves together: the lanes, the events above them, and what marks an instant over both. */
export interface Parts {
  lanes: HTMLCanvasElement;
  events: HTMLCanvasElement;
  overlay: HTMLElement;
}

export interface Shown {
  classes: readonly string[];
  gauges: readonly Gauge[];
}

/** What is asked for of a past, beside the lanes themselves; of disturbances there would be too many. */
const PAST_EVENTS = 1000;
const PAST_KINDS = "desire,intention,exploitation,accomplishment,capacity";

export class LaneChart {
  /** Where the pointer or the keyboard is: share of the width, row. */
  cursor: { share: number; row: number } | null = null;
  rowHeight = 32;
  private shown: Viewport = INITIAL;
  private readonly painter: LanePainter;
  private readonly strip = new Strip();
  private readonly mover: Mover;
  private width = 0;
  private ratio = 1;
  private look = "";
  private marks: RobotEvent[] = [];
  private loose: RobotEvent[] = [];
  private steps: IntentionStep[] = [];
  private exploited = new Map<string, Spell[]>();
  private marksOf: RobotEvent[] | null = null;
  private readonly past: Past;
  private generation = 0;
  private readonly events: CanvasRenderingContext2D;
  private stale = true;
  private endTicks: (() => void) | null = null;
  private frame = 0;

  /** `ticked` is called four times a second while the lanes are seen; `past.came` when what was asked for is there. */
  constructor(
    private readonly parts: Parts,
    private readonly store: Store,
    past: { rest: Rest; came: () => void },
    private readonly shows: () => Shown,
    private readonly ticked: () => void,
  ) {
    this.painter = new LanePainter(parts.lanes.getContext("2d")!);
    this.events = parts.events.getContext("2d")!;
    this.mover = new Mover([parts.lanes, parts.events, parts.overlay], accelerated());
    this.past = new Past(
      {
        lanes: ({ from, to, points }) => past.rest.lanes(from, to, points),
        events: ({ from, to }) => this.eventsBetween(past.rest, from, to),
      },
      () => {
        this.strip.clear();
        this.marksOf = null;
        past.came();
        this.soon();
      },
    );
  }

  get view(): Viewport {
    return this.shown;
  }

  set view(next: Viewport) {
    this.shown = next;
    this.soon();
  }

  get history() {
    return this.store.lanes;
  }

  /** What the window shows, as one history. */
  shownHistory(): LaneHistory {
    const { answer } = this.past;
    const view = this.edges();
    return answer && view.from < this.heard() ? joined(answer.history, this.history, view) : this.history;
  }

  /** Whether `name` was desired at `stamp` or later, as far as is known here. */
  desiredSince(name: string, stamp: number): boolean {
    return this.history.desiredSince(name, stamp) || this.past.answer?.history.desiredSince(name, stamp) === true;
  }

  /** What each lane showed at `stamp`. */
  samples(stamp: number): { name: string; sample: LaneSample }[] {
    const history = this.historyAt(stamp);
    return [...history.lanes.keys()].flatMap((name) => {
      const sample = history.sample(name, stamp);
      return sample ? [{ name, sample }] : [];
    });
  }

  /** The oldest stamp that can be shown. */
  oldest(): number {
    const heard = Math.min(this.heard(), this.now());
    return Math.min(heard, this.past.answer ? (this.past.oldest ?? heard) : this.now() - LONGEST_S);
  }

  get rows(): number {
    return this.shows().classes.length;
  }

  now(): number {
    return this.store.clock.now(performance.now() / 1000) ?? this.store.lanes.newest ?? 0;
  }

  edges(): Edges {
    return edges(this.shown, this.now(), this.trail());
  }

  resize(width: number, rowHeight: number): void {
    this.width = Math.max(1, Math.floor(width));
    this.rowHeight = rowHeight;
    this.look = "";
    this.soon();
  }

  /** While nothing of the lanes is seen, nothing is done. */
  see(seen: boolean): void {
    if (seen === (this.endTicks !== null)) return;
    if (seen) {
      this.endTicks = fourTimesASecond(() => this.tick());
      this.tick();
      return;
    }
    this.endTicks?.();
    this.endTicks = null;
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.mover.stop();
  }

  /** What is under the cursor. */
  hit(): Hit | null {
    return this.cursor && this.at(this.stampAt(this.cursor.share), this.cursor.row);
  }

  stampAt(share: number): number {
    const { from, to } = this.edges();
    return from + (to - from) * share;
  }

  /** What row `row` showed at `stamp`. */
  at(stamp: number, row: number): Hit | null {
    const { classes } = this.shows();
    if (classes.length === 0) return null;
    const place = Math.max(EVENTS_ROW, Math.min(classes.length - 1, row));
    const name = classes[place] ?? "";
    const { from, to } = this.edges();
    const near = (NEAR_PX / this.width) * (to - from);
    const close = (event: RobotEvent) => Math.abs(event.stamp - stamp) <= near;
    const events = this.marks.filter((event) => close(event) && [EVENTS_ROW, place].includes(markRow(event, classes)));
    const apart = (FOLD_PX / this.width) * (to - from);
    const about = folded(this.loose, apart).filter((mark) => mark.from - near <= stamp && stamp <= mark.to + near);
    const x = ((stamp - from) / (to - from)) * this.width;
    const sample = name ? this.historyAt(stamp).sample(name, stamp) : null;
    const selected = sample !== null && ["fulfilled", "degraded"].includes(sample.state);
    return {
      row: place,
      name,
      stamp,
      sample,
      idle: selected ? idleFor(this.exploited.get(name) ?? [], stamp) : null,
      exploited: this.exploits(name, stamp),
      folded: place === EVENTS_ROW ? about : [],
      events: place === EVENTS_ROW ? [] : events,
      x,
      y: place === EVENTS_ROW ? -EVENTS_PX : place * this.rowHeight,
      height: place === EVENTS_ROW ? EVENTS_PX : this.rowHeight,
    };
  }

  exploits(name: string, stamp: number): boolean {
    return (this.exploited.get(name) ?? []).some((spell) => spell.from <= stamp && stamp < spell.to);
  }

  /** What attention had selected at `stamp`; null: not known. */
  intention(stamp: number): IntentionStep | null {
    return intentionAt(this.steps, stamp);
  }

  /** Since when the page has heard the lanes itself. */
  private heard(): number {
    return this.history.count > 0 ? this.history.oldest : Infinity;
  }

  private historyAt(stamp: number): LaneHistory {
    return stamp < this.heard() ? (this.past.answer?.history ?? this.history) : this.history;
  }

  /** Events of a past, up to those that the page has, and those: it forgets them as others come. */
  private async eventsBetween(rest: Rest, from: number, to: number): Promise<RobotEvent[]> {
    const kept = this.store.events.peek();
    const until = Math.min(to, kept[0]?.stamp ?? to);
    return until <= from ? kept : [...(await rest.timeline(PAST_EVENTS, PAST_KINDS, [from, until])), ...kept];
  }

  /** Nothing arrives late in a recording that stands; in one that runs fast, more of it is under way. */
  private trail(): number {
    return this.store.replay.peek() ? TRAIL_S * this.store.clock.rate : TRAIL_S;
  }

  /** At the next frame, once for all that changes until then. */
  soon(): void {
    if (this.endTicks === null || this.frame !== 0) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      this.draw();
    });
  }

  private tick(): void {
    const start = performance.now();
    this.draw();
    this.parts.lanes.dataset["newest"] = String(this.store.lanes.newest ?? "");
    this.ticked();
    // For who observes; kept, they would be ever more.
    performance.measure("lanes", { start });
    performance.clearMeasures("lanes");
  }

  /** Draws what is not drawn yet, and lets the strip go on. */
  private draw(): void {
    const { classes, gauges } = this.shows();
    if (this.width < 2 || classes.length === 0) return;
    const palette = shownTheme.peek() === "light" ? LIGHT : SCREEN;
    this.fit(classes, gauges, palette.ground);
    const view = this.edges();
    this.ask(view);
    this.sortEvents();
    const { history, strip, rowHeight, ratio, marks, exploited, steps } = this;
    const slice = strip.cover(view, history.newest ?? view.to);
    if (slice) {
      if (slice.whole) this.mover.stop();
      const scale = Math.max(1, this.store.hello.value?.scale.intensity ?? 8);
      const past = this.past.answer?.history ?? null;
      const events = { marks, exploited, steps };
      this.painter.paint({ history, past, classes, ...events, gauges, strip, scale, rowHeight, ratio, palette }, slice);
    }
    if (slice?.whole || this.stale) {
      this.stale = false;
      drawEvents(this.events, this.loose, strip, { ratio, palette });
    }
    this.overlay();
    this.mover.show(strip, view, this.shown.heldAt === null ? this.store.clock.rate : 0, ratio);
  }

  /** Asks for what was before the page heard anything. */
  private ask(view: Edges): void {
    if (this.generation !== this.history.generation) {
      this.generation = this.history.generation;
      this.past.clear();
    }
    const now = this.now();
    // Before the robot has said what time it is there, no past of its own can be named.
    if (now === 0) return;
    void this.past.show(wanted(view, this.width * this.ratio, this.heard(), now, this.past.answer), performance.now());
  }

  private overlay(): void {
    const { overlay } = this.parts;
    for (const child of overlay.children as Iterable<HTMLElement>)
      child.style.left = `${Math.round(this.strip.column(Number(child.dataset["stamp"])) / this.ratio)}px`;
  }

  /** The canvases fit what is drawn on them; changed, nothing on them is of use. */
  private fit(classes: readonly string[], gauges: readonly Gauge[], ground: string): void {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const below = gauges.map(({ name, most, budget }) => `${name} ${most} ${budget}`).join();
    const look = `${this.width} ${this.rowHeight} ${ratio} ${ground} ${this.history.generation} ${classes.join()} ${below}`;
    if (look === this.look) return;
    this.look = look;
    this.ratio = ratio;
    this.strip.resize(this.width * ratio, Math.round(PERIOD * ratio));
    const { lanes, events } = this.parts;
    const height = classes.length * this.rowHeight + gauges.length * GAUGE_PX;
    for (const [canvas, high] of [
      [lanes, height],
      [events, EVENTS_PX],
    ] as const) {
      canvas.width = this.strip.columns;
      canvas.height = Math.round(high * ratio);
      canvas.style.width = `${this.strip.columns / ratio}px`;
      canvas.style.height = `${high}px`;
    }
  }

  /** Events may come later than the lanes of their time. */
  private sortEvents(): void {
    const fresh = this.store.events.peek();
    if (this.marksOf === fresh) return;
    const known = new Set(this.marksOf);
    this.marksOf = fresh;
    const first = fresh[0]?.stamp ?? Infinity;
    const events = [...(this.past.answer?.events ?? []).filter((event) => event.stamp < first), ...fresh];
    const { classes } = this.shows();
    this.marks = events.filter((event) => MARKED.has(event.kind));
    this.loose = this.marks.filter((event) => event.kind !== "intention" && markRow(event, classes) === EVENTS_ROW);
    this.loose = this.loose.filter((event) => typeof event.data["class"] !== "string");
    this.steps = intentionSteps(events);
    this.exploited = exploitedSpells(events);
    this.stale = true;
    const drawn = (event: RobotEvent) => MARKED.has(event.kind) || event.kind === "exploitation";
    for (const event of fresh) if (!known.has(event) && drawn(event)) this.strip.invalidate(event.stamp);
  }
}
