/** What to do while nothing has been found; pure. */

import { t } from "../i18n";
import type { BodySkills } from "../state/body";

/** While no QR code has been found. */
export function noneFound({ drives, places }: Pick<BodySkills, "drives" | "places">, replay: boolean): string {
  if (replay) return t("None so far in this recording.");
  const desired = t("while the robot desires to find QR codes");
  if (!places)
    return t(
      "None: this robot measures no distances, so codes get no position. A code in the picture is framed there {desired}.",
      { desired },
    );
  return drives
    ? t("None yet. Drive to within 2 to 4 m of a code {desired}.", { desired })
    : t("None yet. Hold a code less than 2 m from the camera {desired}.", { desired });
}
