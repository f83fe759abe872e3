/** What time it is in what the page shows: the robot's clock, or where the recording is. */

import type { Playback } from "../protocol/types";
import { PlaybackClock } from "./playbackClock";
import { RobotClock } from "./robotClock";

export class PageClock {
  private readonly robot = new RobotClock();
  private readonly recording = new PlaybackClock();
  private replay = false;

  /** A new connection: to a robot, or to a replay. */
  begin(playback: Playback | null, at: number): void {
    this.robot.reset();
    this.recording.reset();
    this.replay = playback !== null;
    if (playback) this.recording.report(playback, at);
  }

  heard(stamp: number, at: number): void {
    if (!this.replay) this.robot.heard(stamp, at);
  }

  roundTrip(rtt: number, at: number): void {
    this.robot.roundTrip(rtt, at);
  }

  played(playback: Playback, at: number): void {
    if (this.replay) this.recording.report(playback, at);
  }

  /** Seconds of what is shown per second: 1 of a robot, 0 of a paused recording. */
  get rate(): number {
    return this.replay ? this.recording.rate : 1;
  }

  now(at: number): number | null {
    return this.replay ? this.recording.now(at) : this.robot.now(at);
  }
}
