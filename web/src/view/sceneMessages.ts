/**
 * What the page and the 3D view's frame say to each other by `postMessage`: the frame may be of another origin and in a
 * process of its own. The frame's half is `app/console/view/inject.html`. Pure.
 */

import type { Viewpoint } from "./viewpoints";

/** A key pressed or let go of in the frame; the names are those of KeyboardEvent. */
export interface Stroke {
  type: "key";
  down: boolean;
  code: string;
  key: string;
  repeat: boolean;
  ctrlKey: boolean;
  altKey: boolean;
  metaKey: boolean;
  shiftKey: boolean;
}

/**
 * From where it looks: `arrived` once its camera is there; `bearing`, `gaze` (rad, left positive): azimuths of the view
 * and of the head by the robot's front.
 */
export interface SceneCamera {
  type: "camera";
  viewpoint: string;
  number: number;
  arrived: boolean;
  bearing: number;
  gaze: number;
}

/** A click at shares of its width from the left and of its height from the top; `viewer` is its name for itself. */
export interface SceneClicked {
  type: "pick";
  viewer: string;
  u: number;
  v: number;
}

export type FromScene =
  /** It is our page, and there. */
  | { type: "ready" }
  | Stroke
  /** Again and again while any is held: all keys that are. */
  | { type: "held"; codes: string[] }
  /** It has lost the keyboard, or is not seen any more. */
  | { type: "blur" }
  /** The mean time between frames lately. */
  | { type: "frames"; ms: number }
  /** Of when (s, the robot's clock) the robot is that is seen now. */
  | { type: "shown"; stamp: number }
  | SceneCamera
  /** A hand has the camera, again and again while it does; or has just let go of it, or turned its wheel. */
  | { type: "hand"; down: boolean }
  | SceneClicked;

export type ToScene =
  /** The codes of keys that viser is to be kept from. */
  | { type: "keys"; codes: string[] }
  /** Another number is another choice. */
  | { type: "viewpoint"; viewpoint: Viewpoint; number: number }
  /** How far aside (rad) the head follows the view; null: it does not. */
  | { type: "soft_limit"; angle: number | null }
  /** Whether anything is held to drive: what is drawn waits for it, where the processor draws. */
  | { type: "driving"; driving: boolean }
  /** The robot answers again: viser shall try at once. */
  | { type: "reconnect" };

/** What an event of the window says of the scene; null unless it comes from the window `scene`, of exactly `origin`. */
export function fromScene(
  event: Pick<MessageEvent, "origin" | "source" | "data">,
  origin: string | null,
  scene: MessageEventSource | null,
): FromScene | null {
  if (origin === null || event.origin !== origin || scene === null || event.source !== scene) return null;
  const said = event.data as Record<string, unknown> | null;
  const fits = typeof said === "object" && said !== null && SHAPES.get(said["type"])?.(said);
  return fits ? (said as unknown as FromScene) : null;
}

const isShare = (value: unknown) => typeof value === "number" && value >= 0 && value <= 1;
const TEXTS = ["code", "key"];
const FLAGS = ["down", "repeat", "ctrlKey", "altKey", "metaKey", "shiftKey"];
const SHAPES: ReadonlyMap<unknown, (said: Record<string, unknown>) => boolean> = new Map([
  ["ready", () => true],
  ["blur", () => true],
  ["frames", ({ ms }) => typeof ms === "number" && ms > 0],
  ["shown", ({ stamp }) => Number.isFinite(stamp)],
  ["hand", ({ down }) => typeof down === "boolean"],
  ["pick", ({ viewer, u, v }) => typeof viewer === "string" && viewer !== "" && isShare(u) && isShare(v)],
  [
    "camera",
    ({ viewpoint, number, arrived, bearing, gaze }) =>
      typeof viewpoint === "string" &&
      typeof number === "number" &&
      typeof arrived === "boolean" &&
      Number.isFinite(bearing) &&
      Number.isFinite(gaze),
  ],
  ["held", ({ codes }) => Array.isArray(codes) && codes.every((code) => typeof code === "string")],
  [
    "key",
    (said) =>
      TEXTS.every((name) => typeof said[name] === "string") && FLAGS.every((name) => typeof said[name] === "boolean"),
  ],
] satisfies [FromScene["type"], (said: Record<string, unknown>) => boolean][]);
