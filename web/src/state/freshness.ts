/** Whether what is shown is the present; pure. */

/** A robot sends its status twenty times a second. */
const STALE_MS = 500;
/** A paused recording sends nothing by itself, but it answers pings: two of them may be lost. */
const REPLAY_STALE_MS = 2600;

/** A local costmap that is older (s) does not show what stands around the robot now. */
const COSTMAP_S = 2;

/** Milliseconds since the last status, and since anything was heard. */
export interface Silence {
  status: number;
  anything: number;
}

export function isFresh(silence: Silence, replay: boolean): boolean {
  return replay ? silence.anything <= REPLAY_STALE_MS : silence.status <= STALE_MS;
}

/** Whether a local costmap made at `stamp` shows what stands around now; time runs at `rate`, in a recording. */
export function showsNow(stamp: number, now: number | null, rate: number): boolean {
  return now === null || now - stamp <= COSTMAP_S * Math.max(1, rate);
}
