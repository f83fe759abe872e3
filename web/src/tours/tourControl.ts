/**
 * The tours, and the one that is edited: each finished edit is sent at once, and shows before the robot has taken it.
 *
 * A change that meets another editor's is joined with it; what both changed, people decide.
 */

import { batch, computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { t } from "../i18n";
import { inWords, Problem } from "../protocol/problem";
import type { KeptTour, TourRest } from "../protocol/tourRest";
import type { Tour, TourList, TourProblemReport } from "../protocol/types";
import type { Store } from "../state/store";
import { MediaControl } from "./mediaControl";
import type { NewTour } from "./tourEdits";
import { equal, merge } from "./tourMerge";
import { mistakes } from "./tourProblems";

/** While tours are looked at, the list is read again so often: others change them, too, and no message says so. */
const EVERY_MS = 5000;

/** Two editors changed the same. */
export interface Conflict {
  theirs: KeptTour;
  /** What, as `stops.arm.title.en`. */
  paths: string[];
}

/** What became of a change; `again`: there is more to send. */
type Sent = "kept" | "refused" | "again" | "conflict";

export class TourControl {
  /** Null: not read yet. */
  readonly list = signal<TourList | null>(null);
  readonly unread = signal("");
  /** As it is edited; null: none is open. */
  readonly draft = signal<Tour | null>(null);
  /** As the robot has it. */
  readonly kept = signal<KeptTour | null>(null);
  readonly conflict = signal<Conflict | null>(null);
  /** Why the last change was not taken; empty: it was. */
  readonly refusal = signal("");
  readonly busy = signal(false);
  /** What is wrong with it: what keeps it from being kept, and what it lacks to run. */
  readonly problems: ReadonlySignal<readonly TourProblemReport[]>;
  /** Whether there are changes that the robot has not taken. */
  readonly unsaved: ReadonlySignal<boolean>;
  /** Whether the robot can be asked for anything. */
  readonly allowed: ReadonlySignal<boolean>;
  readonly media: MediaControl;
  private readonly wrong = signal<TourProblemReport[]>([]);
  private saving: Promise<void> | null = null;

  constructor(
    private readonly store: Store,
    private readonly rest: TourRest,
    /** Whether tours are looked at. */
    readonly shown: ReadonlySignal<boolean>,
  ) {
    this.media = new MediaControl(rest);
    this.problems = computed(() => [...this.wrong.value, ...(this.kept.value?.problems ?? [])]);
    this.unsaved = computed(() => !!this.draft.value && !equal(this.draft.value, this.kept.value?.tour));
    this.allowed = computed(() => store.live.value && !store.replay.value);
  }

  start(): void {
    effect(() => {
      if (!this.shown.value || !this.allowed.value) return;
      void this.refresh();
      const timer = setInterval(() => void this.refresh(), EVERY_MS);
      return () => clearInterval(timer);
    });
  }

  /** Reads the list, and the open tour where another editor has changed it. */
  async refresh(): Promise<void> {
    try {
      const list = await this.rest.tours();
      batch(() => {
        this.list.value = list;
        this.unread.value = "";
      });
    } catch (error) {
      this.unread.value = inWords(error);
      return;
    }
    const open = this.kept.peek();
    const listed = this.list.peek()?.tours.find(({ id }) => id === open?.tour["id"]);
    if (open && listed && listed.etag !== open.etag && !this.saving && !this.unsaved.peek()) await this.open(listed.id);
  }

  /** Ids of all tours that the robot keeps now. */
  async ids(): Promise<string[]> {
    return (await this.rest.tours()).tours.map(({ id }) => id);
  }

  async open(id: string): Promise<boolean> {
    return await this.asked(async () => this.take(await this.rest.tour(id)));
  }

  close(): void {
    batch(() => {
      this.draft.value = this.kept.value = this.conflict.value = null;
      this.refusal.value = "";
      this.wrong.value = [];
    });
  }

  /** Resolves to whether it was created; it is open then. */
  async create(tour: NewTour | Tour): Promise<boolean> {
    const made = await this.asked(async () => this.take(await this.rest.createTour(tour)));
    if (made) await this.refresh();
    return made;
  }

  async importFile(file: Blob): Promise<boolean> {
    const made = await this.asked(async () => this.take(await this.rest.importTour(file)));
    if (made) await this.refresh();
    return made;
  }

  async remove(): Promise<void> {
    const { kept } = this;
    const [id, etag] = [kept.peek()?.tour["id"], kept.peek()?.etag];
    if (typeof id !== "string" || etag === undefined) return;
    if (await this.asked(() => this.rest.deleteTour(id, etag))) {
      this.close();
      await this.refresh();
    }
  }

  /** Shows at once what `change` makes of the tour, and has the robot keep it. */
  edit(change: (tour: Tour) => Tour): Promise<void> {
    const before = this.draft.peek();
    if (!before) return Promise.resolve();
    this.draft.value = change(before);
    return this.save();
  }

  /** Also what was undone with a text editor, or by others. What is not kept yet is gone. */
  async undo(way: "undo" | "redo" = "undo"): Promise<void> {
    await this.saving;
    const open = this.kept.peek();
    if (!open) return;
    const id = String(open.tour["id"]);
    await this.asked(async () => {
      const before = await this.rest.undoTour(id, open.etag, way);
      if (before) this.take(before);
      else this.close();
    });
    await this.refresh();
  }

  /** The conflict is decided: what both changed is mine, or theirs. */
  async decide(whose: "mine" | "theirs"): Promise<void> {
    const conflict = this.conflict.peek();
    const draft = this.draft.peek();
    if (!conflict || !draft) return;
    const base = this.kept.peek()?.tour as unknown as Tour;
    const theirs = conflict.theirs.tour as unknown as Tour;
    // Whose is merged as mine wins.
    const { merged } = whose === "mine" ? merge(base, draft, theirs) : merge(base, theirs, draft);
    batch(() => {
      this.kept.value = conflict.theirs;
      this.draft.value = merged;
      this.conflict.value = null;
    });
    await this.save();
  }

  /** Resolves once the robot has all, or has refused it. */
  save(): Promise<void> {
    this.saving ??= this.saveAll().finally(() => (this.saving = null));
    return this.saving;
  }

  private async saveAll(): Promise<void> {
    this.busy.value = true;
    try {
      while (this.unsaved.peek() && !this.conflict.peek()) {
        const sent = await this.send();
        if (sent === "refused" || sent === "conflict") return;
      }
    } finally {
      this.busy.value = false;
    }
  }

  private async send(): Promise<Sent> {
    const draft = this.draft.peek()!;
    const open = this.kept.peek()!;
    try {
      this.take(await this.rest.replaceTour(draft.id, draft, open.etag), draft);
      return "kept";
    } catch (error) {
      if (error instanceof Problem && error.status === 412) return await this.join(draft.id);
      batch(() => {
        this.refusal.value = inWords(error);
        this.wrong.value = error instanceof Problem && error.status === 422 ? mistakes(error.errors) : [];
      });
      // What was edited meanwhile may be right.
      return this.draft.peek() === draft ? "refused" : "again";
    }
  }

  /** Another editor was faster. */
  private async join(id: string): Promise<Sent> {
    let theirs: KeptTour;
    try {
      theirs = await this.rest.tour(id);
    } catch (error) {
      this.refusal.value = inWords(error);
      return "refused";
    }
    const base = this.kept.peek()!.tour as unknown as Tour;
    const { merged, conflicts } = merge(base, this.draft.peek()!, theirs.tour as unknown as Tour);
    if (conflicts.length > 0) {
      this.conflict.value = { theirs, paths: conflicts };
      return "conflict";
    }
    batch(() => {
      this.kept.value = theirs;
      this.draft.value = merged;
    });
    this.store.notify("info", t("Another editor changed this tour too: both changes are in it."));
    return "again";
  }

  /** `sent`: what was asked for; if the draft is another by now, it stays, to be sent next. */
  private take(kept: KeptTour, sent: Tour | null = this.draft.peek()): void {
    batch(() => {
      this.kept.value = kept;
      if (this.draft.peek() === sent) this.draft.value = kept.tour as unknown as Tour;
      this.refusal.value = "";
      this.wrong.value = [];
      this.conflict.value = null;
    });
  }

  private async asked(request: () => Promise<unknown>): Promise<boolean> {
    this.busy.value = true;
    try {
      await request();
      this.refusal.value = "";
      return true;
    } catch (error) {
      this.refusal.value = inWords(error);
      return false;
    } finally {
      this.busy.value = false;
    }
  }
}
