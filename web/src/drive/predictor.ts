/** Where the robot will be when a command given now arrives, from its last report and the commands sent; and how wrong
 * that was. Pure but for what it remembers. */

import { decimals, t } from "../i18n";
import type { BaseLimits } from "../protocol/types";
import type { Axes } from "./axes";
import { type Commanded, type Motion, predicted, type Velocity } from "./prediction";

/** Commands are remembered so long (s). */
const KEPT_S = 3;
/** What is nearer than this to the measured body is drawn as that alone (m, rad). */
const NEAR = { m: 0.03, rad: 0.035 };
/** A prediction is wrong beyond this, and that is said once it is so for a while (s). */
const WRONG = { m: 0.25, rad: 0.26, lasting_s: 0.4 };

interface Pose {
  x: number;
  y: number;
  theta: number;
}

export class Predictor {
  private commands: Commanded[] = [];
  private made: Motion[] = [];
  private last: Motion | null = null;
  private wrongSince: number | null = null;
  /** How far the robot is from where it was predicted, in words; empty: it is there. */
  wrong = "";

  /** The share of the commanded speeds, 0 to 1, that the robot gives a link that is late. */
  share = 1;

  /** A command that arrives at `arrives` (s, robot's clock); null: nothing is held, and the base stops. */
  command(arrives: number, axes: Axes | null, limits: BaseLimits): void {
    const velocity: Velocity = {
      linear: this.share * (axes?.linear ?? 0) * limits.linear_mps,
      angular: this.share * (axes?.angular ?? 0) * limits.angular_radps,
      lateral: this.share * (axes?.lateral ?? 0) * limits.lateral_mps,
    };
    const stamp = Math.max(arrives, this.commands.at(-1)?.stamp ?? arrives);
    this.commands = [...this.commands.filter((each) => each.stamp > stamp - KEPT_S), { stamp, velocity }];
  }

  /** The robot says where it was: what was predicted for then is compared. */
  measured(motion: Motion): void {
    this.last = motion;
    const due = this.made.filter(({ stamp }) => stamp <= motion.stamp);
    this.made = this.made.filter(({ stamp }) => stamp > motion.stamp);
    const judged = due.at(-1);
    if (!judged) return;
    const off = distance(judged, motion);
    const turned = turn(judged, motion);
    if (off <= WRONG.m && turned <= WRONG.rad) {
      this.wrongSince = null;
      this.wrong = "";
      return;
    }
    this.wrongSince ??= motion.stamp;
    if (motion.stamp - this.wrongSince < WRONG.lasting_s) return;
    const degrees = Math.round((180 / Math.PI) * turned);
    this.wrong =
      off > WRONG.m
        ? t("The robot is {metres} m from where it was expected.", { metres: decimals(off.toFixed(1)) })
        : t("The robot is turned {degrees}° from where it was expected.", { degrees });
  }

  /** Where it will be at `arrives`, in `odom`; null: where it was measured, or nothing is known. */
  ahead(arrives: number, limits: BaseLimits): Pose | null {
    if (!this.last) return null;
    const made = predicted(this.last, this.commands, arrives, limits);
    this.made = [...this.made.filter(({ stamp }) => stamp < made.stamp), made];
    if (distance(made, this.last) < NEAR.m && turn(made, this.last) < NEAR.rad) return null;
    return { x: made.x, y: made.y, theta: made.theta };
  }

  /** Another connection, or another time. */
  reset(): void {
    this.share = 1;
    this.commands = [];
    this.made = [];
    this.last = null;
    this.wrongSince = null;
    this.wrong = "";
  }
}

function distance(a: Pose, b: Pose): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

function turn(a: Pose, b: Pose): number {
  const angle = (a.theta - b.theta) % (2 * Math.PI);
  return Math.min(Math.abs(angle), 2 * Math.PI - Math.abs(angle));
}
