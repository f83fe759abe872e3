/**
 * Where the base will be when a command given now arrives; pure. The same as `app/base/motion_prediction.py`: both are
 * compared with `prediction.examples.json`.
 */

/** Velocities are integrated in steps of at most this (s). */
const STEP_S = 0.02;
/** Nothing is predicted further ahead (s). */
const FARTHEST_S = 1.5;

/** m/s, rad/s, m/s to the left. */
export interface Velocity {
  linear: number;
  angular: number;
  lateral: number;
}

/** In `odom` (m, rad), at `stamp` (s, robot's clock). */
export interface Motion {
  stamp: number;
  x: number;
  y: number;
  theta: number;
  velocity: Velocity;
}

/** From `stamp` (s, robot's clock) on. */
export interface Commanded {
  stamp: number;
  velocity: Velocity;
}

export interface Accelerations {
  linear_mps2: number;
  angular_radps2: number;
}

/** The motion at `until`; before the first of `commands`, which are in order, the base keeps its velocity. */
export function predicted(
  motion: Motion,
  commands: readonly Commanded[],
  until: number,
  { linear_mps2, angular_radps2 }: Accelerations,
): Motion {
  const last = Math.min(Math.max(until, motion.stamp), motion.stamp + FARTHEST_S);
  const edges = commands.map(({ stamp }) => stamp).filter((stamp) => motion.stamp < stamp && stamp < last);
  let now = motion;
  for (const end of [...edges, last]) {
    const wanted = commands.filter(({ stamp }) => stamp <= now.stamp).at(-1)?.velocity ?? now.velocity;
    const steps = Math.max(1, Math.ceil((end - now.stamp) / STEP_S));
    const dt = (end - now.stamp) / steps;
    for (let i = 0; i < steps; i++) {
      const velocity = {
        linear: towards(now.velocity.linear, wanted.linear, linear_mps2 * dt),
        angular: towards(now.velocity.angular, wanted.angular, angular_radps2 * dt),
        lateral: towards(now.velocity.lateral, wanted.lateral, linear_mps2 * dt),
      };
      now = moved(now, velocity, dt);
    }
    now = { ...now, stamp: end };
  }
  return now;
}

function towards(value: number, wanted: number, most: number): number {
  return value + Math.min(Math.max(wanted - value, -most), most);
}

function moved(now: Motion, velocity: Velocity, dt: number): Motion {
  const turn = 0.5 * (now.velocity.angular + velocity.angular) * dt;
  const forward = 0.5 * (now.velocity.linear + velocity.linear) * dt;
  const left = 0.5 * (now.velocity.lateral + velocity.lateral) * dt;
  const heading = now.theta + 0.5 * turn;
  const cos = Math.cos(heading);
  const sin = Math.sin(heading);
  return {
    stamp: now.stamp + dt,
    x: now.x + cos * forward - sin * left,
    y: now.y + sin * forward + cos * left,
    theta: now.theta + turn,
    velocity,
  };
}
