/** Whether the face that is shown is the robot's of now. Pure. */

/** `login`: the console wants a login first. */
export type Link = "live" | "lost" | "login";

/** A face so much older (s) than the robot's clock is not its face of now: its body gives no joints any more. */
export const OLD_S = 2;

/** `open`: the connection stands. `newest` and `now`: stamps (robot's clock, s) of the newest face and of the robot's last
 * answer; null: there is none. On a paused recording both stand. */
export function linkOf(open: boolean, newest: number | null, now: number | null): Link {
  return open && newest !== null && (now === null || now - newest <= OLD_S) ? "live" : "lost";
}
