/**
 * The 3D view's frame: where its page comes from, whether it is there, and what is said with it. Its page comes from a
 * port of its own, where the browser may give it a process of its own; where that port is not reached (a proxy, a tunnel
 * of one port), from ours.
 */

import { signal } from "@preact/signals";
import { SceneKeys } from "./sceneKeys";
import { type FromScene, fromScene, type Stroke, type ToScene } from "./sceneMessages";

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
  private readonly keys: SceneKeys;
  private taken: string[] = [];
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

  private take(message: FromScene): void {
    if (message.type === "ready") {
      this.stopWaiting();
      this.keys.release(); // of the page that was there before
      this.state.value = "shown";
      this.say({ type: "keys", codes: this.taken });
    } else if (message.type === "frames") this.parts.frames(message.ms);
    else this.keys.take(message);
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
