/** The way of the tour that is edited, planned again whenever the tour, its places or the zones change. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { t } from "../i18n";
import { inWords, Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Place, RouteReport, Tour, Zone } from "../protocol/types";
import { equal } from "./tourMerge";
import { type Itinerary, itinerary, type Leg, legsOf } from "./tourRoute";

/** An edit is often followed by the next. */
const SETTLED_MS = 300;
/** After so long a robot that is busy planning for others is asked again. */
const AGAIN_MS = 2000;
const BUSY = "Busy";

interface Sources {
  draft: ReadonlySignal<Tour | null>;
  places: ReadonlySignal<readonly Place[]>;
  zones: ReadonlySignal<readonly Zone[]>;
  /** The map in use; null: not known. */
  map: ReadonlySignal<string | null>;
  /** Whether the robot goes anywhere by itself, and is there to be asked. */
  able: ReadonlySignal<boolean>;
}

export class RouteControl {
  /** In the order of the tour. */
  readonly legs = signal<readonly Leg[]>([]);
  /** Why there is no route; empty: there is. */
  readonly lack = signal("");
  readonly planning = signal(false);
  private asked: unknown = null;
  private turn = 0;
  /** Until the last request is answered: a slow robot is asked for one route at a time. */
  private answered: Promise<void> = Promise.resolve();
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly rest: Rest,
    private readonly from: Sources,
  ) {}

  start(): void {
    const { draft, places, zones, map, able } = this.from;
    const wanted = computed(() => {
      const tour = draft.value;
      if (!tour || !able.value) return null;
      const where = places.value.map(({ id, x, y, heading }) => ({ id, x, y, heading }));
      return {
        tour,
        speed: tour.pace.speed,
        map: map.value,
        way: itinerary(tour, places.value),
        where,
        zones: zones.value,
      };
    });
    effect(() => {
      const now = wanted.value;
      if (!now) {
        this.forget("");
        return;
      }
      if (now.map !== null && now.map !== now.tour.map) {
        this.forget(
          t("This tour is on the map {map}; {used} is in use.", { map: now.tour.map, used: now.map || t("a new map") }),
        );
        return;
      }
      const { tour: _, ...key } = now;
      if (equal(key, this.asked)) return;
      this.asked = key;
      const turn = ++this.turn;
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.queue(turn, now.tour, now.way), SETTLED_MS);
    });
  }

  private queue(turn: number, tour: Tour, way: Itinerary): void {
    this.answered = this.answered.then(() => this.plan(turn, tour, way));
  }

  private async plan(turn: number, tour: Tour, way: Itinerary): Promise<void> {
    if (turn !== this.turn) return;
    let route: RouteReport | null = null;
    let lack = "";
    this.planning.value = true;
    try {
      if (way.points.length > 1) route = await this.rest.planRoute({ points: way.points, speed: tour.pace.speed });
    } catch (error) {
      if (error instanceof Problem && error.title === BUSY && turn === this.turn) {
        this.timer = setTimeout(() => this.queue(turn, tour, way), AGAIN_MS);
        return;
      }
      lack = inWords(error);
    }
    if (turn !== this.turn) return;
    this.planning.value = false;
    this.lack.value = lack;
    this.legs.value = legsOf(tour, way, route);
  }

  private forget(why: string): void {
    this.turn++;
    clearTimeout(this.timer);
    this.asked = null;
    this.planning.value = false;
    this.lack.value = why;
    this.legs.value = [];
  }
}
