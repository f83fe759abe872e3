/** Configures a tour by driving it once: looks for posters on the way, and makes a tour of them at the end. */

import { effect, signal } from "@preact/signals";
import { t } from "../i18n";
import type { MapLibrary } from "../map/library";
import type { MapControl } from "../map/mapControl";
import { type PlaceControl, placeOf } from "../map/placeControl";
import { inWords } from "../protocol/problem";
import { idempotencyKey } from "../protocol/requests";
import type { Rest } from "../protocol/rest";
import type { Store } from "../state/store";
import { type DrivenTour, drivenOn, newDrivenTour, tourOf, without } from "./drivenTour";
import type { TourControl } from "./tourControl";
import { posterTitle } from "./tourEdits";

const KEY = "hbba.driven-tour";
const LOOKS_FOR = "FindQRCodes";
/** The desire to look for posters ends by itself with a page that is gone. */
const LOOKS_S = 3600;

export class TourDrive {
  /** Null: none is configured now. A page that is loaded again goes on with it. */
  readonly tour = signal<DrivenTour | null>(restored());
  readonly busy = signal(false);
  readonly problem = signal("");

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
    private readonly map: MapControl,
    private readonly maps: MapLibrary,
    private readonly places: PlaceControl,
    private readonly tours: TourControl,
  ) {}

  start(): void {
    effect(() => {
      const landmarks = this.store.of("landmarks").value?.landmarks;
      const tour = this.tour.peek();
      if (tour && landmarks) this.tour.value = drivenOn(tour, landmarks);
    });
    effect(() => {
      const tour = this.tour.value;
      if (tour) localStorage.setItem(KEY, JSON.stringify(tour));
      else localStorage.removeItem(KEY);
    });
  }

  /** From now on posters that are seen become stops. */
  async begin(title: string, language: string): Promise<void> {
    this.problem.value = "";
    this.tours.close();
    this.tour.value = newDrivenTour(title, language, this.store.of("landmarks").peek()?.landmarks ?? []);
    await this.map.desireMap();
    const lane = this.store.rows.peek().find((row) => row.class === LOOKS_FOR);
    if ((lane && lane.state !== "undesired") || !this.serves(LOOKS_FOR)) return;
    const desire = { class: LOOKS_FOR, intensity: 7, utility: 4, ttl: LOOKS_S };
    await this.rest.addDesire(desire, idempotencyKey()).catch((error) => {
      this.problem.value = inWords(error);
    });
  }

  leaveOut(landmark: number): void {
    const tour = this.tour.peek();
    if (tour) this.tour.value = without(tour, landmark);
  }

  discard(): void {
    this.tour.value = null;
    this.problem.value = "";
  }

  /** Keeps the map (under `mapName`, if it has none), makes a place before each poster, and the tour of them. */
  async finish(mapName: string): Promise<void> {
    const tour = this.tour.peek();
    if (!tour) return;
    this.busy.value = true;
    this.problem.value = "";
    try {
      const inUse = this.maps.inUse.peek();
      const name = inUse || mapName.trim();
      if (!inUse && (await this.rest.maps()).maps.some((map) => map.name === name)) {
        this.problem.value = t("There is a map {name} already: choose another name.", { name });
        return;
      }
      await this.rest.saveMap(name);
      const places = await this.placed(tour);
      const taken = await this.tours.ids();
      if (!(await this.tours.create(tourOf(tour, name, taken, places)))) {
        this.problem.value = this.tours.refusal.peek();
        return;
      }
      await this.maps.refresh();
      this.tour.value = null;
      this.store.notify("info", t("The tour {title} is kept, and so is the map {name}.", { title: tour.title, name }));
    } catch (error) {
      this.problem.value = inWords(error);
    } finally {
      this.busy.value = false;
    }
  }

  /** Ids of places by the numbers of posters. One that gets none is said, and left out of the tour. */
  private async placed(tour: DrivenTour): Promise<Map<number, string>> {
    const found = new Map<number, string>();
    const names = this.places.all.peek().map(({ name }) => name);
    for (const { text, landmark, x, y } of tour.met) {
      const there = placeOf(this.places.all.peek(), { id: landmark, text });
      if (there) {
        found.set(landmark, there.id);
        continue;
      }
      const title = posterTitle(text).slice(0, 60);
      const named = names.includes(title) ? {} : { name: title };
      try {
        const made = await this.rest.addPlace({ ...named, poster: { text, near: [x, y] } });
        names.push(made.name);
        found.set(landmark, made.id);
      } catch (error) {
        this.store.notify(
          "warning",
          t("{text} is no stop: {error}", { text: posterTitle(text), error: inWords(error) }),
        );
      }
    }
    return found;
  }

  private serves(kind: string): boolean {
    return (this.store.hello.peek()?.classes ?? []).some(({ name, served }) => name === kind && served);
  }
}

function restored(): DrivenTour | null {
  const text = typeof localStorage === "undefined" ? null : localStorage.getItem(KEY);
  return text === null ? null : (JSON.parse(text) as DrivenTour);
}
