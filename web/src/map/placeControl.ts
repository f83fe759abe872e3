/** The places of the map: made, renamed and deleted. */

import { computed, type ReadonlySignal, signal } from "@preact/signals";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Landmark, NewPlace, Place } from "../protocol/types";
import type { Store } from "../state/store";
import { sentence } from "../ui/format";

export class PlaceControl {
  /** Whether something was asked for and has not been answered yet. */
  readonly busy = signal(false);
  readonly all: ReadonlySignal<readonly Place[]>;
  /** Whether this program keeps places. */
  readonly kept: ReadonlySignal<boolean>;

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
  ) {
    this.all = computed(() => store.of("places").value?.places ?? []);
    this.kept = computed(() => store.of("places").value !== null);
  }

  /** Where the robot is now. */
  addHere(): Promise<boolean> {
    return this.add({ here: true });
  }

  /** In front of a poster; of several with its text, of this one. */
  addBefore({ text, x, y }: Landmark): Promise<boolean> {
    return this.add({ poster: { text, near: [x, y] } });
  }

  rename(place: Place, name: string): Promise<boolean> {
    return this.ask(() => this.rest.changePlace(place, { name }));
  }

  remove(place: Place): Promise<boolean> {
    return this.ask(() => this.rest.deletePlace(place));
  }

  private add(place: NewPlace): Promise<boolean> {
    return this.ask(async () => {
      const { name, problem } = await this.rest.addPlace(place);
      if (problem)
        this.store.notify("warning", t("New place: {name}. {problem}", { name, problem: sentence(problem) }));
      else this.store.notify("info", t("New place: {name}.", { name }));
    });
  }

  /** Resolves to whether it was done; why not is shown. */
  private async ask(request: () => Promise<void>): Promise<boolean> {
    this.busy.value = true;
    try {
      await request();
      return true;
    } catch (error) {
      this.store.notify("error", inWords(error));
      return false;
    } finally {
      this.busy.value = false;
    }
  }
}

/** Why no place can be made in front of a poster; empty: one can. */
export function posterLack({ frame, heading }: Pick<Landmark, "frame" | "heading">): string {
  if (frame !== "map") return t("Where it hangs on the map is not known: start SLAM.");
  return heading === null ? t("Which way it faces is not known yet: look at it from nearer by.") : "";
}

/** The place that is in front of a poster, if there is one. */
export function placeOf(places: readonly Place[], { id, text }: Pick<Landmark, "id" | "text">): Place | null {
  return places.find(({ poster, landmark }) => poster === text && landmark === id) ?? null;
}

/** What is wrong with a place's new name; empty: nothing. */
export function placeNameProblem(places: readonly Place[], name: string, of: Place): string {
  const trimmed = name.trim();
  if (trimmed === "") return t("A name is needed.");
  if (trimmed.length > 60) return t("At most 60 characters.");
  if (places.some((place) => place.name === trimmed && place.id !== of.id)) return t("Another place has this name.");
  return "";
}
