/** Begins and steers the tour under way, and reads the reports of those that are over. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { inWords } from "../protocol/problem";
import type { TourRest } from "../protocol/tourRest";
import type { NewTourRun, RunReport, Tour, TourPress, TourProgress, TourSummary, VisitorLink } from "../protocol/types";
import type { Store } from "../state/store";
import type { TourControl } from "./tourControl";
import { isThere } from "./tourRunText";

export class TourRunControl {
  /** How the tour goes; null: none is led, and none waits for visitors. */
  readonly progress: ReadonlySignal<TourProgress | null>;
  /** Whether anything can be pressed. */
  readonly allowed: ReadonlySignal<boolean>;
  readonly busy = signal(false);
  /** Why the last press did nothing; empty: it did. */
  readonly refusal = signal("");
  /** The newest first; null: not read yet. */
  readonly reports = signal<readonly RunReport[] | null>(null);
  /** Id of the tour that people chose to begin; empty: the one that is edited, or the first that can run. */
  readonly wanted = signal("");
  /** Of the tour to begin; empty: its first. */
  readonly language = signal("");
  readonly chosen: ReadonlySignal<TourSummary | null>;
  /** How visitors' phones get in; null: not known. */
  readonly link = signal<VisitorLink | null>(null);
  /** Stops of the tour under way that are not left out. */
  readonly stops = signal<Tour["stops"]>([]);

  constructor(
    store: Store,
    private readonly rest: TourRest,
    private readonly tours: TourControl,
  ) {
    this.progress = computed(() => {
      const progress = store.of("tour").value;
      return isThere(progress) ? progress : null;
    });
    this.allowed = computed(() => store.live.value && !store.replay.value && !this.busy.value);
    this.chosen = computed(() => {
      const able = (tours.list.value?.tours ?? []).filter(({ problem }) => problem === null);
      const named = (id: string | undefined) => able.find((tour) => tour.id === id);
      return (
        named(this.wanted.value) ??
        named(tours.draft.value?.id) ??
        able.find(({ errors }) => errors === 0) ??
        able[0] ??
        null
      );
    });
  }

  start(): void {
    const under = computed(() => this.progress.value?.tour ?? "");
    effect(() => {
      const id = under.value;
      this.stops.value = [];
      if (id) void this.readStops(id);
    });
    // Each run has another key; of a tour that waits, the end of a run makes the next one's.
    const run = computed(() => (this.progress.value ? `${under.value} ${this.progress.value.state === "idle"}` : ""));
    effect(() => {
      this.link.value = null;
      if (run.value && this.allowed.peek()) void this.readLink();
    });
    // A run that has ended left a report.
    const leads = computed(() => (this.progress.value?.state ?? "idle") !== "idle");
    effect(() => {
      if (!leads.value && this.tours.shown.value && this.tours.allowed.value) void this.readReports();
    });
  }

  async begin(how: "now" | "visitors"): Promise<void> {
    const tour = this.chosen.peek();
    if (!tour) return;
    const language = tour.languages.includes(this.language.peek()) ? this.language.peek() : tour.languages[0];
    const wish: NewTourRun = { begin: how, ...(language === undefined ? {} : { language }) };
    await this.asked(() => this.rest.startTour(tour.id, wish));
  }

  async press(what: TourPress): Promise<void> {
    await this.asked(() => this.rest.pressTour(what));
  }

  /** Waits for visitors no more. */
  async dismiss(): Promise<void> {
    await this.asked(() => this.rest.dismissTour());
  }

  async deleteReport(run: string): Promise<void> {
    await this.asked(() => this.rest.deleteTourReport(run));
    await this.readReports();
  }

  async readReports(): Promise<void> {
    try {
      this.reports.value = await this.rest.tourReports();
    } catch (error) {
      this.refusal.value = inWords(error);
    }
  }

  private async readLink(): Promise<void> {
    try {
      this.link.value = await this.rest.visitorLink();
    } catch {
      this.link.value = null; // visitors see it on the robot's face, too
    }
  }

  private async readStops(id: string): Promise<void> {
    try {
      const tour = (await this.rest.tour(id)).tour as unknown as Tour;
      if (this.progress.peek()?.tour === id) this.stops.value = tour.stops.filter((stop) => !stop.left_out);
    } catch (error) {
      this.refusal.value = inWords(error);
    }
  }

  private async asked(request: () => Promise<unknown>): Promise<void> {
    this.busy.value = true;
    try {
      await request();
      this.refusal.value = "";
    } catch (error) {
      this.refusal.value = inWords(error);
    } finally {
      this.busy.value = false;
    }
  }
}
