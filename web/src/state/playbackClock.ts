/**
 * The time of a recording that is played, between the ten reports a second of its position.
 *
 * It runs at the pace that the last reports really had, not at the speed asked for: a computer may be too slow for that,
 * and "as fast as possible" has no figure. Small differences are taken in smoothly and never backwards; a pause, a jump
 * and a great difference at once.
 */

import type { Playback } from "../protocol/types";

type Report = Pick<Playback, "position" | "end" | "speed" | "playing">;

const WINDOW_S = 1.5;
/** Reports closer together than this say too little about the pace. */
const MEASURE_S = 0.4;
const BLEND = 0.25;
/** Of real time: off by more, the clock is set again. */
const JUMP_S = 0.5;

export class PlaybackClock {
  private reports: { position: number; at: number }[] = [];
  private last: Report | null = null;
  private base = 0;
  private baseAt = 0;
  private shown = -Infinity;
  /** Seconds of the recording per second. */
  rate = 0;

  /** `at` is the page's monotonic time of arrival, seconds. */
  report(report: Report, at: number): void {
    const before = this.last;
    const running = this.now(at);
    this.last = report;
    const same = before?.playing === true && report.playing && before.speed === report.speed;
    if (!same || this.reports.some((other) => other.position > report.position)) this.reports = [];
    this.reports.push({ position: report.position, at });
    while (this.reports[0]!.at < at - WINDOW_S) this.reports.shift();
    this.rate = report.playing ? this.pace(report.speed, same ? this.rate : null) : 0;
    const off = running === null ? Infinity : report.position - running;
    if (same && Math.abs(off) <= JUMP_S * Math.max(1, this.rate)) this.base = running! + BLEND * off;
    else {
      this.base = report.position;
      this.shown = -Infinity;
    }
    this.baseAt = at;
  }

  /** The recording's time at the page's monotonic time `at`; null before the first report. */
  now(at: number): number | null {
    if (!this.last) return null;
    const ahead = this.last.playing ? this.rate * Math.max(0, at - this.baseAt) : 0;
    this.shown = Math.max(this.shown, Math.min(this.base + ahead, this.last.end));
    return this.shown;
  }

  reset(): void {
    this.reports = [];
    this.last = null;
    this.shown = -Infinity;
    this.rate = 0;
  }

  private pace(speed: number | null, before: number | null): number {
    const [first, last] = [this.reports[0]!, this.reports.at(-1)!];
    if (last.at - first.at >= MEASURE_S) return (last.position - first.position) / (last.at - first.at);
    return before ?? speed ?? 1;
  }
}
