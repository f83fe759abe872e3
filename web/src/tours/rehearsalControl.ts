/** Has the open tour rehearsed, and plays what came of it on the map. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { inWords } from "../protocol/problem";
import type { TourRest } from "../protocol/tourRest";
import type { Rehearsal, RehearsalReport } from "../protocol/types";
import { markAt, type RehearsedMark, speedOf } from "./rehearsalPlay";
import type { TourControl } from "./tourControl";

const ASK_MS = 500;
const TICK_MS = 50;

export class RehearsalControl {
  /** Null: none was asked for. */
  readonly report = signal<RehearsalReport | null>(null);
  readonly refusal = signal("");
  /** The moment that is shown (s since its begin). */
  readonly at = signal(0);
  readonly playing = signal(false);
  /** Of the tour that is open; null: there is none. */
  readonly result: ReadonlySignal<Rehearsal | null>;
  /** The robot's mark on the map; null: there is none. */
  readonly mark: ReadonlySignal<RehearsedMark | null>;

  constructor(
    private readonly rest: TourRest,
    private readonly tours: TourControl,
  ) {
    this.result = computed(() => {
      const { result = null } = this.report.value ?? {};
      return result && result.tour === this.tours.draft.value?.id ? result : null;
    });
    this.mark = computed(() => (this.result.value ? markAt(this.result.value, this.at.value) : null));
  }

  start(): void {
    effect(() => {
      if (this.report.value?.state !== "running") return;
      const timer = setTimeout(() => void this.ask(), ASK_MS);
      return () => clearTimeout(timer);
    });
    effect(() => {
      const result = this.result.value;
      if (!this.playing.value || !result) return;
      const timer = setInterval(() => {
        const next = this.at.peek() + (speedOf(result) * TICK_MS) / 1000;
        this.at.value = Math.min(next, result.duration_s);
        if (next >= result.duration_s) this.playing.value = false;
      }, TICK_MS);
      return () => clearInterval(timer);
    });
  }

  /** Rehearses the open tour, as the robot keeps it. */
  async begin(language: string): Promise<void> {
    const id = this.tours.draft.peek()?.id;
    if (id === undefined) return;
    this.at.value = 0;
    this.playing.value = false;
    await this.tours.save();
    await this.asked(async () => (this.report.value = await this.rest.rehearse(id, { language })));
  }

  /** Ends the one that runs, or forgets the last. */
  async cancel(): Promise<void> {
    this.playing.value = false;
    await this.asked(async () => {
      await this.rest.cancelRehearsal();
      this.report.value = null;
    });
  }

  play(): void {
    const result = this.result.peek();
    if (!result) return;
    if (this.at.peek() >= result.duration_s) this.at.value = 0;
    this.playing.value = !this.playing.peek();
  }

  private async ask(): Promise<void> {
    await this.asked(async () => {
      const report = await this.rest.rehearsal();
      // Another page may have cancelled it.
      this.report.value = report.state === "none" ? null : report;
      if (report.state === "done") this.playing.value = true;
    });
  }

  private async asked(request: () => Promise<unknown>): Promise<void> {
    try {
      await request();
      this.refusal.value = "";
    } catch (error) {
      this.refusal.value = inWords(error);
      // One that cannot be asked is asked again while it runs.
      const report = this.report.peek();
      if (report?.state === "running") this.report.value = { ...report };
    }
  }
}
