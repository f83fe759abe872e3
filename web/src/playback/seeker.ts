/** Sends where a hand drags the timeline: one request at a time, the newest wins, what is asked for shows at once. */

export class Seeker {
  /** Where the hand wants to be, until the robot is there; null: nobody asks. */
  wanted: number | null = null;
  private next: number | null = null;
  private busy = false;

  /** Between two requests lie at least `restMs`. `changed` is called whenever `wanted` is another; `failed` with what a refusal threw. */
  constructor(
    private readonly send: (position: number) => Promise<void>,
    private readonly changed: () => void,
    private readonly failed: (error: unknown) => void,
    private readonly restMs = 0,
  ) {}

  to(position: number): void {
    this.wanted = this.next = position;
    this.changed();
    if (!this.busy) void this.work();
  }

  private async rest(): Promise<void> {
    if (this.restMs > 0) await new Promise((resolve) => setTimeout(resolve, this.restMs));
  }

  private async work(): Promise<void> {
    this.busy = true;
    while (this.next !== null) {
      const position = this.next;
      this.next = null;
      try {
        await Promise.all([this.send(position), this.rest()]);
      } catch (error) {
        if (this.next === null) this.failed(error);
      }
    }
    this.busy = false;
    this.wanted = null;
    this.changed();
  }
}
