/**
 * Keys held in the 3D view's frame, as keys of the page. A hold ends with the key, with the frame's focus, and when
 * the frame falls silent: its process may hang, and then no key is seen to be let go of.
 */

import type { FromScene, Stroke } from "./sceneMessages";

/** The frame says every 100 ms what is held; it may draw for longer than that. */
export const SILENT_MS = 500;
const WATCH_MS = 100;
/** A page that was busy itself reads first what came meanwhile. */
const READ_MS = 40;

export class SceneKeys {
  private readonly held = new Map<string, Stroke>();
  private heardAt = 0;
  private watchedAt = 0;
  private watching: ReturnType<typeof setInterval> | undefined;

  /** `strike` presses or lets go of a key on the page. */
  constructor(private readonly strike: (stroke: Stroke) => void) {}

  take(message: FromScene): void {
    this.heardAt = performance.now();
    if (message.type === "key") this.key(message);
    else if (message.type === "blur") this.release();
    else if (message.type === "held") this.release(new Set(message.codes));
  }

  /** Lets go of all keys but those `still` held. */
  release(still: ReadonlySet<string> = new Set()): void {
    for (const [code, stroke] of [...this.held]) {
      if (still.has(code)) continue;
      this.held.delete(code);
      this.strike({ ...stroke, down: false, repeat: false });
    }
    if (this.held.size > 0) return;
    clearInterval(this.watching);
    this.watching = undefined;
  }

  private key(stroke: Stroke): void {
    if (stroke.down) this.held.set(stroke.code, stroke);
    else this.held.delete(stroke.code);
    this.strike(stroke);
    if (this.held.size === 0) this.release();
    else this.watch();
  }

  private watch(): void {
    if (this.watching !== undefined) return;
    this.watchedAt = this.heardAt;
    this.watching = setInterval(() => {
      const now = performance.now();
      const late = now - this.watchedAt > 2 * WATCH_MS;
      this.watchedAt = now;
      if (late) setTimeout(() => this.judge(), READ_MS);
      else this.judge();
    }, WATCH_MS);
  }

  private judge(): void {
    if (performance.now() - this.heardAt > SILENT_MS) this.release();
  }
}
