/** What to do where there is nothing to tell yet; pure. */

import type { BodySkills } from "../state/body";

/** While no QR code has been found. */
export function noneFound({ drives, places }: Pick<BodySkills, "drives" | "places">, replay: boolean): string {
  if (replay) return "None by this moment of the recording.";
  const desired = "while the robot desires to find QR codes";
  if (!places)
    return `None: this robot measures no distances, so a code has no place. Held into the picture ${desired}, it is framed there.`;
  return drives
    ? `None yet. Drive up to a poster: from 2 m it is read, often from 4 m already, ${desired}.`
    : `None yet. Hold one before the camera, under 2 m, ${desired}.`;
}
