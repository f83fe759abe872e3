/**
 * The robot's clock as the page knows it.
 *
 * Every stamped message gives one sample `stamp − arrival`; the least delayed of the last seconds (the largest) is
 * nearest the truth, and half the shortest round trip is added back. The estimate slews instead of jumping, so that
 * what scrolls with it scrolls smoothly, except when it is off by more than `JUMP_S` (a new connection, a set clock).
 */

const WINDOW_S = 10;
const SLEW = 0.02; // seconds of correction per second: below what an eye sees in a scrolling lane
const JUMP_S = 0.5;

export class RobotClock {
  private samples: { at: number; offset: number }[] = [];
  private trips: { at: number; rtt: number }[] = [];
  private offset: number | null = null;
  private slewedAt = 0;

  /** `at` is the page's monotonic time of arrival, seconds. */
  heard(stamp: number, at: number): void {
    const offset = stamp - at;
    while (this.samples.length > 0 && this.samples[this.samples.length - 1]!.offset <= offset) this.samples.pop();
    this.samples.push({ at, offset });
    while (this.samples[0]!.at < at - WINDOW_S) this.samples.shift();
  }

  /** One round trip of `rtt` seconds ended at `at`. */
  roundTrip(rtt: number, at: number): void {
    while (this.trips.length > 0 && this.trips[this.trips.length - 1]!.rtt >= rtt) this.trips.pop();
    this.trips.push({ at, rtt });
    while (this.trips[0]!.at < at - WINDOW_S) this.trips.shift();
  }

  /** The robot's clock at the page's monotonic time `at`; null before anything was heard. */
  now(at: number): number | null {
    const best = this.samples[0];
    if (!best) return null;
    const target = best.offset + (this.trips[0]?.rtt ?? 0) / 2;
    if (this.offset === null || Math.abs(target - this.offset) > JUMP_S) this.offset = target;
    else {
      const reach = SLEW * Math.max(0, at - this.slewedAt);
      this.offset += Math.max(-reach, Math.min(reach, target - this.offset));
    }
    this.slewedAt = at;
    return at + this.offset;
  }

  reset(): void {
    this.samples = [];
    this.trips = [];
  }
}
