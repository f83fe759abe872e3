/** A click in the 3D view: the point of a tour's step, or what can be done with what is there. */

import { signal } from "@preact/signals";
import { inWords } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Landmark, SceneClick, ScenePoint } from "../protocol/types";
import type { Store } from "../state/store";
import type { TourPointing } from "../tours/tourPointing";
import type { SceneClicked } from "./sceneMessages";

/** What was clicked at these shares of the view's width and height; `poster`: the one that it is. */
export interface Picked extends Pick<SceneClick, "u" | "v"> {
  kind: Exclude<ScenePoint["kind"], "nothing">;
  /** Whether the place is one on the map. */
  onMap: boolean;
  x: number;
  y: number;
  z: number;
  poster: Landmark | null;
}

export class ScenePicking {
  readonly picked = signal<Picked | null>(null);
  /** Another number: what was asked for before is no longer wanted. */
  private turn = 0;

  constructor(
    private readonly store: Store,
    private readonly rest: Pick<Rest, "scenePoint">,
    private readonly pointing: Pick<TourPointing, "target" | "scene">,
  ) {}

  async click({ viewer, u, v }: SceneClicked): Promise<void> {
    this.close();
    const { body, live, replay } = this.store;
    if (!live.peek() || replay.peek() || !body.peek().maps) return;
    const turn = this.turn;
    try {
      const point = await this.rest.scenePoint({ viewer, u, v });
      if (turn !== this.turn) return;
      if (this.pointing.target.peek()) this.pointing.scene(point);
      else this.picked.value = pickedOf(point, { u, v }, this.store.of("landmarks").peek()?.landmarks ?? []);
    } catch (error) {
      if (turn === this.turn) this.store.notify("error", inWords(error));
    }
  }

  close(): void {
    this.turn += 1;
    this.picked.value = null;
  }
}

/** What was clicked `at` there; null: nothing, or a poster that is none of `landmarks` any more. */
export function pickedOf(
  point: ScenePoint,
  at: Pick<SceneClick, "u" | "v">,
  landmarks: readonly Landmark[],
): Picked | null {
  const { kind, frame, x, y, z, text, landmark } = point;
  if (kind === "nothing" || x === null || y === null || z === null) return null;
  const poster = landmarks.find((one) => one.id === landmark && one.text === text && one.frame === frame) ?? null;
  if (kind === "poster" && poster === null) return null;
  return { kind, onMap: frame === "map", x, y, z, poster, u: at.u, v: at.v };
}
