/** Keeps the predictor fed: with the commands sent, the robot's reports, the clocks. */

import { type ReadonlySignal, signal } from "@preact/signals";
import type { Session } from "../state/session";
import type { Store } from "../state/store";
import type { DriveController } from "./driveController";
import { Predictor } from "./predictor";

interface Pose {
  x: number;
  y: number;
  theta: number;
}

/** In `odom`: where the robot will be when a command given now arrives; null: where it is measured. */
export interface Ahead {
  pose: ReadonlySignal<Pose | null>;
  /** How far it is from where it was expected, in words; empty: it is there. */
  wrong: ReadonlySignal<string>;
}

export function lookAhead(store: Store, session: Session, drive: DriveController): Ahead {
  const pose = signal<Pose | null>(null);
  const wrong = signal("");
  const predictor = new Predictor();
  const limits = () => store.hello.peek()?.robot.limits;
  /** The robot's time when what is sent now arrives. */
  const arrival = () => {
    const now = store.clock.now(performance.now() / 1000);
    return now === null ? null : now + (store.rttMs.peek() ?? 0) / 2000;
  };
  drive.onSent = (command) => {
    const [arrives, body] = [arrival(), limits()];
    if (arrives !== null && body) predictor.command(arrives, command.held ? command : null, body);
  };
  session.on("status", ({ stamp, odometry, driver, share }) => {
    predictor.share = share ?? 1; // an older program says none
    const [arrives, body] = [arrival(), limits()];
    if (!odometry || arrives === null || !body || store.replay.peek()) return;
    const velocity = {
      linear: odometry.linear_mps,
      angular: odometry.angular_radps,
      lateral: odometry.lateral_mps ?? 0,
    };
    predictor.measured({ stamp, x: odometry.x, y: odometry.y, theta: odometry.theta, velocity });
    const found = predictor.ahead(arrives, body);
    // What drives by itself, or by another's hand, is not predicted by this page's commands.
    pose.value = driver?.mine ? found : null;
    wrong.value = driver?.mine ? predictor.wrong : "";
  });
  session.onHello.add(() => {
    predictor.reset();
    pose.value = null;
    wrong.value = "";
  });
  return { pose, wrong };
}
