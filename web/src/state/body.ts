/** What the body, and the program on it, can do: what it cannot is not offered. Pure. */

import type { Hello } from "../protocol/types";

export interface BodySkills {
  /** Hands can drive it. */
  drives: boolean;
  /** It moves sideways. */
  strafes: boolean;
  /** Hands can turn its head. */
  turnsHead: boolean;
  /** It makes, or shows, a map. */
  maps: boolean;
  /** It goes by itself where it is sent. */
  goes: boolean;
  /** A laser scan comes. */
  scans: boolean;
  /** What it sees gets a place in the room: by depth, or by the laser. */
  places: boolean;
  /** It looks for faces, listens for where voices are. */
  faces: boolean;
  voices: boolean;
}

/** Of one that has not greeted yet: all but the unusual. */
export function bodyOf(hello: Hello | null): BodySkills {
  const { scan, point_cloud, map } = hello?.channels ?? {};
  const serves = (kind: string) => !hello || hello.classes.some(({ name, served }) => name === kind && served);
  const recorded = !!hello?.playback;
  return {
    drives: hello?.drive !== false,
    strafes: (hello?.robot?.limits.lateral_mps ?? 0) > 0,
    turnsHead: hello?.head !== false,
    maps: map !== false,
    goes: serves("GoTo"),
    scans: scan !== false,
    places: scan !== false || point_cloud !== false,
    faces: recorded || serves("LocateFaces"),
    voices: recorded || serves("LocateVoices"),
  };
}
