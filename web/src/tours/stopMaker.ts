/** Makes stops of the open tour: before a poster that was found, where the robot is, or at a place of the map. */

import { signal } from "@preact/signals";
import { t } from "../i18n";
import { type PlaceControl, placeOf, posterLack } from "../map/placeControl";
import { inWords } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Landmark, NewPlace, Place } from "../protocol/types";
import type { Store } from "../state/store";
import type { TourControl } from "./tourControl";
import { newStop, posterTitle, stopOf, withStop } from "./tourEdits";

/** How near a click has to be to a poster's mark, px. */
const NEAR_PX = 14;

export class StopMaker {
  /** Id of the stop whose form is open; null: none. */
  readonly open = signal<string | null>(null);
  /** A poster that was clicked on the map. */
  readonly picked = signal<Landmark | null>(null);

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
    private readonly places: PlaceControl,
    private readonly tours: TourControl,
  ) {}

  /** Why no stop can be made before a poster; empty: one can. */
  lack(landmark: Landmark): string {
    const tour = this.tours.draft.value;
    if (!tour) return t("No tour is open.");
    if (stopOf(tour, landmark)) return t("It is a stop of this tour already.");
    return placeOf(this.places.all.value, landmark) ? "" : posterLack(landmark);
  }

  async fromPoster(landmark: Landmark): Promise<void> {
    this.picked.value = null;
    const { text, x, y } = landmark;
    const there = placeOf(this.places.all.peek(), landmark);
    const place =
      there ?? (await this.made({ poster: { text, near: [x, y] }, name: this.freeName(posterTitle(text)) }));
    if (place) await this.add(place, posterTitle(text), text);
  }

  async here(): Promise<void> {
    const place = await this.made({ here: true, name: this.freeName(this.nextTitle()) });
    if (place) await this.add(place, place.name, "");
  }

  /** On the floor, with that heading (rad). */
  async on({ x, y }: { x: number; y: number }, heading: number): Promise<void> {
    const place = await this.made({ pose: { x, y, heading }, name: this.freeName(this.nextTitle()) });
    if (place) await this.add(place, place.name, "");
  }

  async at(place: Place): Promise<void> {
    await this.add(place, place.name, place.source === "poster" ? place.poster : "");
  }

  /** A click on the map at `at` (m), `scale` px a metre; returns whether a poster is there. */
  pick(at: { x: number; y: number }, scale: number): boolean {
    this.picked.value = null;
    if (!this.tours.draft.peek()) return false;
    const away = ({ x, y }: Landmark) => Math.hypot(x - at.x, y - at.y) * scale;
    const near = (this.store.of("landmarks").peek()?.landmarks ?? [])
      .filter((one) => one.frame === "map" && away(one) <= NEAR_PX)
      .sort((a, b) => away(a) - away(b))[0];
    this.picked.value = near ?? null;
    return near !== undefined;
  }

  private async add(place: Place, title: string, poster: string): Promise<void> {
    let id = "";
    await this.tours.edit((tour) => {
      const stop = newStop(tour, place.id, title, poster && stopOf(tour, { text: poster }) ? "" : poster);
      id = stop.id;
      return withStop(tour, stop);
    });
    this.open.value = id;
  }

  private nextTitle(): string {
    return `Stop ${(this.tours.draft.peek()?.stops.length ?? 0) + 1}`;
  }

  private freeName(wanted: string): string {
    const names = this.places.all.peek().map(({ name }) => name);
    const plain = wanted.slice(0, 56);
    for (let number = 1; ; number++) {
      const name = number === 1 ? plain : `${plain} ${number}`;
      if (!names.includes(name)) return name;
    }
  }

  private async made(place: NewPlace): Promise<Place | null> {
    try {
      const made = await this.rest.addPlace(place);
      if (made.problem)
        this.store.notify(
          "warning",
          t("{name} is a place now, but {problem}.", { name: made.name, problem: made.problem }),
        );
      return made;
    } catch (error) {
      this.store.notify("error", inWords(error));
      return null;
    }
  }
}
