/**
 * Mode 2 at work: while a hand has the view's camera, or drives, head and base follow the view as driving commands, by
 * the lease like any. It stops by default: when the hand lets go, when the view falls silent, when the page is left.
 */

import { computed, signal } from "@preact/signals";
import type { DriveController } from "./driveController";
import { TICK_MS } from "./machine";
import {
  type Directions,
  type Follow,
  follow,
  LEAST_LIMIT_DEG,
  MOST_LIMIT_DEG,
  SOFT_LIMIT_DEG,
  type SoftLimit,
  STILL,
  type ViewMode,
} from "./viewFollow";

/** The frame says every 100 ms that a hand has its camera. */
export const SILENT_MS = 500;
/** The console says five times a second where the view looks, and a frame that draws slowly passes that on. */
export const UNSEEN_MS = 1000;
const LIMIT_KEY = "hbba.softLimit";

export class FollowControl {
  readonly mode = signal<ViewMode>(1);
  /** Degrees to either side. */
  readonly limit = signal(readLimit());
  /** Of the head, in degrees, as last seen. */
  private readonly gaze = signal(0);
  /** null: the head does not follow the view. */
  readonly softLimit = computed<SoftLimit | null>((): SoftLimit | null => {
    if (this.mode.value !== 2) return null;
    return { angle: (this.limit.value * Math.PI) / 180, past: this.past.value };
  });
  private readonly past = computed(() => Math.abs(this.gaze.value) > this.limit.value);
  private handAt = Number.NEGATIVE_INFINITY;
  private seenAt = Number.NEGATIVE_INFINITY;
  private seen: Directions | null = null;
  private state: Follow = STILL;
  private giving = false;
  private beatAt = 0;
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly drive: Pick<DriveController, "input" | "state">,
    private readonly now: () => number = () => performance.now(),
    private readonly focused: () => boolean = () => document.hasFocus(),
  ) {}

  choose(mode: ViewMode): void {
    this.mode.value = mode;
    if (mode === 1) this.stop();
    else this.timer ??= setInterval(() => this.beat(), TICK_MS);
  }

  setLimit(degrees: number): void {
    this.limit.value = clamped(degrees);
    localStorage.setItem(LIMIT_KEY, String(this.limit.value));
  }

  /** A hand has the view's camera, still, or has let go of it. */
  hand(down: boolean): void {
    this.handAt = down ? this.now() : Number.NEGATIVE_INFINITY;
    if (!down) this.beat();
  }

  /** Where the view and the head look, in rad. */
  look({ bearing, gaze }: Directions): void {
    this.seenAt = this.now();
    this.seen = { bearing: degrees(bearing), gaze: degrees(gaze) };
    this.gaze.value = this.seen.gaze;
  }

  /** Ends it: the view is gone. */
  stop(): void {
    clearInterval(this.timer);
    this.timer = undefined;
    this.handAt = Number.NEGATIVE_INFINITY;
    this.give(null);
  }

  beat(): void {
    const now = this.now();
    const passed = (now - this.beatAt) / 1000;
    this.beatAt = now;
    const held = now - this.handAt <= SILENT_MS || this.drive.state.peek().source !== null;
    const known = this.seen !== null && now - this.seenAt <= UNSEEN_MS;
    if (this.mode.peek() !== 2 || !held || !known || !this.focused()) this.give(null);
    else this.give(follow(this.state, this.seen!, this.limit.peek(), passed));
  }

  private give(given: Follow | null): void {
    if (given === null && !this.giving) return;
    this.giving = given !== null;
    this.state = given ?? STILL;
    this.drive.input({ type: "follow", axes: given && { pan: given.pan, angular: given.angular } });
  }
}

function degrees(angle: number): number {
  return (angle * 180) / Math.PI;
}

function clamped(limit: number): number {
  return Number.isFinite(limit) ? Math.max(LEAST_LIMIT_DEG, Math.min(MOST_LIMIT_DEG, limit)) : SOFT_LIMIT_DEG;
}

function readLimit(): number {
  const kept = typeof localStorage === "undefined" ? null : localStorage.getItem(LIMIT_KEY);
  return kept === null ? SOFT_LIMIT_DEG : clamped(Number(kept));
}
