/**
 * The 3D view's frame: where its page comes from, whether it is there, and what is said with it. Its page comes from a
 * port of its own, where the browser may give it a process of its own; where that port is not reached (a proxy, a tunnel
 * of one port), from ours.
 */

import { signal } from "@preact/signals";
import { SceneKeys } from "./sceneKeys";
import {
  type FromScene,
  fromScene,
  type SceneCamera,
  type SceneClicked,
  type Stroke,
  type ToScene,
} from "./sceneMessages";
import type { Viewpoint } from "./viewpoints";

/** Its page has loaded, and says so within this time; an error page of the browser never does. */
export const READY_WITHIN_MS = 2000;

export type SceneState = "loading" | "shown" | "missing";

export interface SceneParts {
  /** Address of the view at our own origin. */
  own: string;
  /** Finds the address where the view is best taken from. */
  find: () => Promise<string>;
  /** The frame's window; null: none yet. */
  inner: () => Window | null;
  /** Presses or lets go of a key on the page. */
  strike: (stroke: Stroke) => void;
  /** The frame says its mean time between frames. */
  frames: (ms: number) => void;
}

export class SceneFrame {
  readonly state = signal<SceneState>("loading");
  /** The frame's address; null: being sought. */
  readonly address = signal<string | null>(null);
  /** Counts loads: another number is another frame. */
  readonly load = signal(0);
  /** What it looks from, as it says, and whether it is there; null: not known yet. */
  readonly camera = signal<Pick<SceneCamera, "viewpoint" | "arrived"> | null>(null);
  /** Of when (s, the robot's clock) the robot is that it shows; null: not known yet. */
  readonly stamp = signal<number | null>(null);
  /** Called several times a second with where it looks. */
  onCamera: (camera: SceneCamera) => void = () => {};
  /** Called while a hand has its camera, again and again, and when it has let go of it or turned its wheel. */
  onHand: (down: boolean) => void = () => {};
  /** Called with a click in it. */
  onPicked: (click: SceneClicked) => void = () => {};
  private readonly keys: SceneKeys;
  private choice: { viewpoint: Viewpoint; number: number } | null = null;
  private taken: string[] = [];
  private softLimit: number | null = null;
  private turn = 0;
  /** Something has loaded that has not said yet that it is our page. */
  private ready: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly parts: SceneParts) {
    this.keys = new SceneKeys(parts.strike);
  }

  /** Looks for the view's address, and loads it from there. */
  async open(): Promise<void> {
    const address = await this.sought();
    if (address !== null) this.show(address);
  }

  /** The robot answers, at first or after a while: at the same address, or it was started again elsewhere. */
  async answered(): Promise<void> {
    const address = await this.sought();
    if (address === null) return;
    const failed = this.state.peek() === "missing" || this.ready !== undefined;
    if (failed || address !== this.address.peek()) this.show(address);
    else this.say({ type: "reconnect" });
  }

  close(): void {
    this.turn += 1;
    this.stopWaiting();
    this.keys.release();
  }

  /** The frame has loaded something: our page, or a page of an error. */
  loaded(): void {
    this.stopWaiting();
    if (this.state.peek() === "loading") this.ready = setTimeout(() => this.unreached(), READY_WITHIN_MS);
  }

  receive(event: Pick<MessageEvent, "origin" | "source" | "data">): void {
    const message = fromScene(event, this.origin, this.parts.inner());
    if (message) this.take(message);
  }

  /** The codes of keys that are the page's, not viser's. */
  takeKeys(codes: string[]): void {
    this.taken = codes;
    this.say({ type: "keys", codes });
  }

  /** Something is held to drive, or nothing is any more. */
  drives(driving: boolean): void {
    this.say({ type: "driving", driving });
  }

  /** The head follows the view as far aside (rad); null: it does not. */
  limits(angle: number | null): void {
    if (angle === this.softLimit) return;
    this.softLimit = angle;
    this.say({ type: "soft_limit", angle });
  }

  /** Looks from there; chosen again, it goes back there. */
  look(viewpoint: Viewpoint): void {
    this.choice = { viewpoint, number: (this.choice?.number ?? 0) + 1 };
    this.camera.value = { viewpoint, arrived: false };
    this.say({ type: "viewpoint", ...this.choice });
  }

  private take(message: FromScene): void {
    if (message.type === "ready") {
      this.stopWaiting();
      this.keys.release(); // of the page that was there before
      this.state.value = "shown";
      this.say({ type: "keys", codes: this.taken });
      this.camera.value = null;
      this.stamp.value = null;
      if (this.choice) this.say({ type: "viewpoint", ...this.choice });
      if (this.softLimit !== null) this.say({ type: "soft_limit", angle: this.softLimit });
    } else if (message.type === "frames") this.parts.frames(message.ms);
    else if (message.type === "shown") this.stamp.value = message.stamp;
    else if (message.type === "camera") this.takeCamera(message);
    else if (message.type === "hand") this.onHand(message.down);
    else if (message.type === "pick") this.onPicked(message);
    else this.keys.take(message);
  }

  private takeCamera(camera: SceneCamera): void {
    this.onCamera(camera);
    // What was chosen in the meantime it does not know yet.
    if (camera.number !== (this.choice?.number ?? 0)) return;
    const { viewpoint, arrived } = camera;
    const before = this.camera.peek();
    if (before?.viewpoint !== viewpoint || before.arrived !== arrived) this.camera.value = { viewpoint, arrived };
  }

  private async sought(): Promise<string | null> {
    this.turn += 1;
    const turn = this.turn;
    const address = await this.parts.find();
    return turn === this.turn ? address : null;
  }

  private show(address: string): void {
    this.stopWaiting();
    this.keys.release();
    this.state.value = "loading";
    this.address.value = address;
    this.load.value += 1;
  }

  private unreached(): void {
    this.ready = undefined;
    if (this.address.peek() !== this.parts.own) this.show(this.parts.own);
    else this.state.value = "missing";
  }

  private stopWaiting(): void {
    clearTimeout(this.ready);
    this.ready = undefined;
  }

  private get origin(): string | null {
    const address = this.address.peek();
    return address === null ? null : new URL(address).origin;
  }

  private say(message: ToScene): void {
    const origin = this.origin;
    if (origin !== null && this.state.peek() === "shown") this.parts.inner()?.postMessage(message, origin);
  }
}
