/** Plays, pauses and moves the recording that the page shows: buttons and keys in, REST out. */

import { signal } from "@preact/signals";
import { inWords } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Playback } from "../protocol/types";
import type { Store } from "../state/store";
import { type Action, actionOf, type Key, target } from "./transport";
import { Turns } from "./turns";

const SEEK_REST_MS = 90;

export class PlaybackController {
  /** Where the timeline was asked to go and is not yet; null: nowhere. */
  readonly wanted = signal<number | null>(null);
  private readonly turns: Turns;

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
  ) {
    this.turns = new Turns(
      async (position) => this.take(await this.rest.playback({ position })),
      () => (this.wanted.value = this.turns.wanted),
      (error) => this.store.notify("error", inWords(error)),
      SEEK_REST_MS,
    );
  }

  /** True if the key meant something. */
  key(key: Key): boolean {
    const action = actionOf(key);
    if (action) this.act(action);
    return action !== null;
  }

  act(action: Action): void {
    const playback = this.store.playback.peek();
    if (!playback) return;
    const to = target(action, this.wanted.peek() ?? playback.position, playback);
    if (to !== null) {
      // A step back is to look at a moment: it must not run away again.
      if (action === "back" && playback.playing) this.ask(() => this.rest.playback({ playing: false }));
      this.seek(to);
    } else if (action === "step") this.ask(() => this.rest.stepPlayback());
    else this.ask(() => this.toggle());
  }

  seek(position: number): void {
    this.turns.seek(position);
  }

  speed(speed: number | null): void {
    this.ask(() => this.rest.playback({ speed }));
  }

  /** Decided by the recording's state when the request's turn comes: earlier requests may have changed it. */
  private async toggle(): Promise<Playback> {
    const playback = this.store.playback.peek();
    if (playback?.phase === "ended") return this.rest.playback({ position: playback.begin, playing: true });
    return this.rest.playback({ playing: !playback?.playing });
  }

  private ask(request: () => Promise<Playback>): void {
    this.turns.ask(async () => this.take(await request()));
  }

  /** What the answer says of the playback is newer than the last report. */
  private take(answer: Playback): void {
    if (!this.store.playback.peek()) return;
    this.store.clock.played(answer, performance.now() / 1000);
    this.store.playback.value = answer;
  }
}
