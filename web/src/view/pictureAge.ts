/** How old the camera's picture is, glass to glass: from the robot's lens to this screen. Pure. */

import { t } from "../i18n";
import { number } from "../ui/format";

/** A picture older than this is said to be late, and than the other, is greyed (s of the robot, at its own pace). */
export const LATE_S = 0.5;
export const OLD_S = 1;

export interface ShownAge {
  text: string;
  late: boolean;
  title: string;
}

export function isOld(age: number, rate: number): boolean {
  return age > OLD_S * Math.max(1, rate);
}

/** `age` in s, at `rate` of the robot's clock; null: nothing is to be said. In a recording only what is old is. */
export function pictureAge(age: number, rate: number, recorded: boolean): ShownAge | null {
  const old = isOld(age, rate);
  if (!Number.isFinite(age) || (recorded && !old)) return null;
  const late = age > LATE_S * Math.max(1, rate);
  const text = old
    ? t("{age} s old", { age: number(age, 1) })
    : t("{count} ms", { count: 10 * Math.round(100 * Math.max(0, age)) });
  const meaning = t("Age of the picture, glass to glass: since the robot's camera took it, until you see it.");
  return {
    text,
    late,
    title: late ? t("{meaning} What you do now comes later still: drive slowly.", { meaning }) : meaning,
  };
}
