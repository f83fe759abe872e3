/** A point of a step that is chosen by a click: on the map, in the camera's picture, or in the 3D view. */

import { effect, signal } from "@preact/signals";
import { t } from "../i18n";
import type { MapControl } from "../map/mapControl";
import { inWords } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { ScenePoint } from "../protocol/types";
import type { Store } from "../state/store";
import { narrow } from "../ui/media";
import type { TourControl } from "./tourControl";
import { type PointTarget, withPoint } from "./tourPath";

export class TourPointing {
  /** What the next click is for. */
  readonly target = signal<PointTarget | null>(null);

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
    private readonly map: MapControl,
    private readonly tours: TourControl,
  ) {}

  start(): void {
    this.map.onPoint = ({ x, y }) => this.chosen([x, y]);
    effect(() => {
      // Another tool, or another tour: the click is for nothing here any more.
      if (this.map.tools.value.tool !== "point" || !this.tours.draft.value) this.target.value = null;
    });
  }

  isFor({ path, part }: PointTarget): boolean {
    return this.target.value?.path === path && this.target.value.part === part;
  }

  /** Null: no click is waited for any more. */
  choose(target: PointTarget | null): void {
    if ((target !== null) !== (this.map.tools.peek().tool === "point")) this.map.choose("point");
    this.target.value = target;
    if (target && this.store.mapPlace.peek() !== "view" && !this.inScene()) this.store.showTour("view");
    if (!target && narrow.peek()) this.store.showTour("tab"); // where the step's form is
  }

  /** A click in the camera's picture taken at `stamp`, `u` and `v` as shares of its width and height. */
  async picture(stamp: number, u: number, v: number): Promise<void> {
    try {
      const { x, y, z, measured } = await this.rest.cameraPoint({ stamp, u, v });
      this.chosen([x, y, z]);
      if (!measured)
        this.store.notify(
          "warning",
          t("The camera measured no distance there: the point lies on the floor, or 4 m away."),
        );
    } catch (error) {
      this.store.notify("error", inWords(error));
    }
  }

  /** A click in the 3D view, on what it shows there. */
  scene({ kind, frame, x, y, z }: ScenePoint): void {
    if (kind === "nothing") this.store.notify("info", t("Nothing is there: click on the floor or on a thing."));
    else if (frame !== "map") this.store.notify("error", t("Where this is on the map is not known: start SLAM."));
    else this.chosen([x!, y!, z!]);
  }

  /** Whether the 3D view is what is looked at: then a click in it will do, and no map has to come. */
  private inScene(): boolean {
    const { around, camera, mapPlace, sceneShown } = this.store;
    const covered = [camera, around].some((inset) => inset.peek() === "large");
    return sceneShown.peek() && mapPlace.peek() === "tab" && !covered && !narrow.peek();
  }

  private chosen(point: [x: number, y: number, z?: number]): void {
    const target = this.target.peek();
    if (!target) return;
    const [x, y, z] = point.map((value) => Math.round(value! * 100) / 100) as typeof point;
    void this.tours.edit((tour) => withPoint(tour, target, [x, y, z]));
    this.choose(null);
  }
}
