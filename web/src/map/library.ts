/** The kept maps: read, saved, loaded, renamed, deleted, started. */

import { batch, computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { KeptMaps, PoseReport } from "../protocol/types";
import type { Store } from "../state/store";

/** A module that is only starting is asked for again so soon. */
const AGAIN_MS = 1000;
/** While the list is looked at, it is read again so often: others change it, too, and no message says so. */
const EVERY_MS = 5000;
const NAME = /^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$/;

export class MapLibrary {
  /** Null: not read yet. */
  readonly list = signal<KeptMaps | null>(null);
  /** What is under way, in words; empty: nothing. */
  readonly doing = signal("");
  /** Why the last thing that was asked for failed; empty: it did not. */
  readonly problem = signal("");
  /** Why the list could not be read the last time; empty: it could. */
  readonly unread = signal("");
  /** Whether the module that keeps maps runs. */
  readonly available = computed(() => this.list.value?.current.available ?? false);
  /**
   * What the map in use is called, empty: nothing yet; null: not known. From the list, for localization names
   * only with the next scan, and of none while SLAM rests; or as that says where it has changed since.
   */
  readonly inUse = signal<string | null>(null);
  private readonly wanted: ReadonlySignal<boolean>;
  private reading: Promise<void> | null = null;
  private stale = false;
  private again: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
    private readonly shown: ReadonlySignal<boolean>,
    /** Has the robot map, or follow itself on its map. */
    private readonly awaken: () => Promise<void>,
  ) {
    const { hello, live, replay } = store;
    this.wanted = computed(() => this.shown.value && live.value && !replay.value && !!hello.value?.channels.map);
  }

  start(): void {
    const { hello, of } = this.store;
    const localizedOn = computed(() => of("localization").value?.map);
    effect(() => {
      if (localizedOn.value !== undefined) this.inUse.value = localizedOn.value;
    });
    effect(() => {
      void [localizedOn.value, hello.value];
      if (this.wanted.value) void this.refresh();
    });
    effect(() => {
      if (!this.wanted.value) return;
      const timer = setInterval(() => void this.refresh(), EVERY_MS);
      return () => clearInterval(timer);
    });
  }

  save(name: string): Promise<boolean> {
    return this.ask(t("Saving {name}…", { name }), () => this.rest.saveMap(name), t("Saved as {name}.", { name }));
  }

  load(name: string, options: { pose?: PoseReport; extend: boolean }): Promise<boolean> {
    return this.ask(
      t("Loading {name}…", { name }),
      () => this.awake(this.rest.loadMap(name, options)),
      t("{name} is in use.", { name }),
    );
  }

  rename(name: string, to: string): Promise<boolean> {
    return this.ask(
      t("Renaming {name}…", { name }),
      () => this.rest.renameMap(name, to),
      t("{name} is called {to} now.", { name, to }),
    );
  }

  remove(name: string): Promise<boolean> {
    return this.ask(
      t("Deleting {name}…", { name }),
      () => this.rest.deleteMap(name),
      t("{name} is deleted.", { name }),
    );
  }

  begin(): Promise<boolean> {
    return this.ask(t("Starting a new map…"), () => this.awake(this.rest.beginMap()), t("A new map has started."));
  }

  /** Resolves when a list is there that was asked for no earlier than now. */
  async refresh(): Promise<void> {
    this.stale = true;
    this.reading ??= this.read().finally(() => (this.reading = null));
    await this.reading;
  }

  private async read(): Promise<void> {
    clearTimeout(this.again);
    try {
      while (this.stale) {
        this.stale = false;
        const list = await this.rest.maps();
        if (!this.stale) this.take(list); // or something has changed since it was asked for
      }
      if (!this.available.peek() && this.wanted.peek()) this.again = setTimeout(() => void this.refresh(), AGAIN_MS);
    } catch (error) {
      this.unread.value = inWords(error);
    }
  }

  private take(list: KeptMaps): void {
    batch(() => {
      this.unread.value = "";
      this.list.value = list;
      if (list.current.available) this.inUse.value = list.current.name;
    });
  }

  /** A map that is taken into use is shown with the robot on it. */
  private async awake(taken: Promise<void>): Promise<void> {
    await taken;
    await this.awaken();
  }

  private async ask(doing: string, request: () => Promise<void>, done: string): Promise<boolean> {
    this.doing.value = doing;
    this.problem.value = "";
    try {
      await request();
      this.store.notify("info", done);
      await this.refresh();
      return true;
    } catch (error) {
      this.problem.value = inWords(error);
      return false;
    } finally {
      this.doing.value = "";
    }
  }
}

/** What is wrong with a map's name; empty: nothing. */
export function nameProblem(name: string): string {
  if (name === "") return t("A name is needed.");
  if (NAME.test(name)) return "";
  if (!/^[A-Za-z0-9]/.test(name)) return t("Begins with a letter or a digit.");
  if (name.length > 100) return t("At most 100 characters.");
  return t("No spaces: letters, digits, dots, - and _ only.");
}
