/**
 * Moves strips through the view: the compositor does it, by whole device pixels, with no script between two ticks. Where
 * the processor draws, each tick moves them: a compositor that moves something makes 60 frames a second.
 */

import type { Edges, Strip } from "./strip";

/** Slower than this (device pixels per second), a tick moves the strips itself. */
const CRAWL = 5;
/** So far (s) may the compositor's place differ from the clock's before it is set right. */
const DRIFT_S = 0.08;

export class Mover {
  private animations: Animation[] = [];
  private start = 0;
  private steps = 0;
  private speed = 0;
  private readonly still = window.matchMedia("(prefers-reduced-motion: reduce)");

  constructor(
    private readonly elements: readonly HTMLElement[],
    private readonly smooth: boolean,
  ) {}

  /** Shows `edges` of the strip, and goes on from there at `rate` seconds of the strip per second. */
  show(strip: Strip, edges: Edges, rate: number, ratio: number): void {
    const column = strip.column(edges.from);
    const speed = strip.perSecond * rate;
    if (!this.smooth || speed < CRAWL || this.still.matches) {
      this.stop();
      this.place(Math.round(column) / ratio);
      return;
    }
    const off = Math.abs(this.at() - column);
    if (this.speed === speed && off <= Math.max(2, DRIFT_S * speed)) return;
    this.stop();
    this.start = Math.floor(column);
    this.steps = Math.max(1, strip.room(edges));
    this.speed = speed;
    const [from, to] = [this.start / ratio, (this.start + this.steps) / ratio];
    this.place(from);
    this.animations = this.elements.map((element) =>
      element.animate([{ transform: `translateX(${-from}px)` }, { transform: `translateX(${-to}px)` }], {
        duration: (this.steps / speed) * 1000,
        easing: `steps(${this.steps})`,
        fill: "forwards",
      }),
    );
  }

  /** The strip has another beginning: what moves is of the old one. */
  stop(): void {
    for (const animation of this.animations) animation.cancel();
    this.animations = [];
    this.speed = 0;
  }

  /** The column at the left edge of the view now. */
  private at(): number {
    const played = this.animations[0]?.currentTime;
    return typeof played === "number" ? this.start + Math.min(this.steps, (played / 1000) * this.speed) : -Infinity;
  }

  private place(x: number): void {
    for (const element of this.elements) element.style.transform = `translateX(${-x}px)`;
  }
}
