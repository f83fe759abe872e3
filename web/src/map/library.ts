/** The kept maps: read, saved, loaded, renamed, deleted, begun. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { inWords, type Rest } from "../protocol/rest";
import type { KeptMaps, Place } from "../protocol/types";
import type { Store } from "../state/store";

/** A module that is only starting is asked for again so soon. */
const AGAIN_MS = 1000;
const NAME = /^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$/;

export class MapLibrary {
  /** Null: not read yet. */
  readonly list = signal<KeptMaps | null>(null);
  /** What is under way, in words; empty: nothing. */
  readonly doing = signal("");
  /** Why the last thing, or the list, failed; empty: it did not. */
  readonly problem = signal("");
  /** Whether there is anybody who keeps maps by now. */
  readonly available = computed(() => this.list.value?.current.available ?? false);
  private reading = false;
  private again: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
    private readonly shown: ReadonlySignal<boolean>,
    /** Has the robot map, or follow itself on its map. */
    private readonly awaken: () => Promise<void>,
  ) {}

  start(): void {
    effect(() => {
      void this.store.localization.value?.map;
      if (this.shown.value && this.store.live.value && !this.store.replay.value && this.store.hello.value?.channels.map)
        void this.refresh();
    });
  }

  save(name: string): Promise<boolean> {
    return this.ask(`Saving ${name}…`, () => this.rest.saveMap(name), `Saved as ${name}.`);
  }

  load(name: string, options: { pose?: Place; extend: boolean }): Promise<boolean> {
    return this.ask(`Loading ${name}…`, () => this.awake(this.rest.loadMap(name, options)), `${name} is in use.`);
  }

  rename(name: string, to: string): Promise<boolean> {
    return this.ask(`Renaming ${name}…`, () => this.rest.renameMap(name, to), `${name} is called ${to} now.`);
  }

  remove(name: string): Promise<boolean> {
    return this.ask(`Deleting ${name}…`, () => this.rest.deleteMap(name), `${name} is deleted.`);
  }

  begin(): Promise<boolean> {
    return this.ask("Beginning a new map…", () => this.awake(this.rest.beginMap()), "A new map has begun.");
  }

  async refresh(): Promise<void> {
    if (this.reading) return;
    this.reading = true;
    try {
      this.list.value = await this.rest.maps();
      clearTimeout(this.again);
      if (!this.available.peek() && this.shown.peek()) this.again = setTimeout(() => void this.refresh(), AGAIN_MS);
    } catch (error) {
      this.problem.value = inWords(error);
    } finally {
      this.reading = false;
    }
  }

  /** Whoever takes a map into use wants to see the robot on it. */
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
  if (name === "") return "A name is needed.";
  if (NAME.test(name)) return "";
  if (!/^[A-Za-z0-9]/.test(name)) return "Begins with a letter or a digit.";
  if (name.length > 100) return "At most 100 characters.";
  return "Letters, digits, dots, - and _ only.";
}
