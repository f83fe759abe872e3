/** What is asked of a playback, in the order of the hand: one request at a time; of seeks in a row the newest counts. */

interface Seek {
  position: number;
}
type Request = () => Promise<void>;

export class Turns {
  /** The position asked for, until the recording is there; null: none. */
  wanted: number | null = null;
  private waiting: (Seek | Request)[] = [];
  private busy = false;

  /** After a seek the next request waits until `restMs` have passed. `changed` is called whenever `wanted` is another; `failed` with what a refusal threw. */
  constructor(
    private readonly send: (position: number) => Promise<void>,
    private readonly changed: () => void,
    private readonly failed: (error: unknown) => void,
    private readonly restMs = 0,
  ) {}

  /** Shown at once, sent when its turn comes. */
  seek(position: number): void {
    this.wanted = position;
    this.changed();
    const last = this.waiting.at(-1);
    if (last && typeof last !== "function") last.position = position;
    else this.waiting.push({ position });
    if (!this.busy) void this.work();
  }

  /** A request that must find done what was asked before it. */
  ask(request: Request): void {
    this.waiting.push(request);
    if (!this.busy) void this.work();
  }

  private get seeksWait(): boolean {
    return this.waiting.some((each) => typeof each !== "function");
  }

  private async work(): Promise<void> {
    this.busy = true;
    for (let next = this.waiting.shift(); next; next = this.waiting.shift()) {
      const seeks = typeof next !== "function";
      try {
        await (typeof next === "function" ? next() : Promise.all([this.send(next.position), this.rest()]));
      } catch (error) {
        // Where the hand is elsewhere by now, what it left is of no interest.
        if (!seeks || !this.seeksWait) this.failed(error);
      }
      if (seeks && !this.seeksWait) {
        this.wanted = null;
        this.changed();
      }
    }
    this.busy = false;
  }

  private async rest(): Promise<void> {
    if (this.restMs > 0) await new Promise((resolve) => setTimeout(resolve, this.restMs));
  }
}
