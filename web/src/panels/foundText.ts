/** What to do while nothing has been found; pure. */

import type { BodySkills } from "../state/body";

/** While no QR code has been found. */
export function noneFound({ drives, places }: Pick<BodySkills, "drives" | "places">, replay: boolean): string {
  if (replay) return "None so far in this recording.";
  const desired = "while the robot desires to find QR codes";
  if (!places)
    return `None: this robot measures no distances, so codes get no position. A code in the picture is framed there ${desired}.`;
  return drives
    ? `None yet. Drive to within 2 to 4 m of a code ${desired}.`
    : `None yet. Hold a code less than 2 m from the camera ${desired}.`;
}
