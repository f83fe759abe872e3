/** How old the camera's picture is, glass to glass: from the robot's lens to this screen; and the 3D view. Pure. */

import { type Text, t } from "../i18n";
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
  return {
    text,
    late,
    title: titled("Age of the picture, glass to glass: since the robot's camera took it, until you see it.", late),
  };
}

/** `age` (s) of the robot in the 3D view, at `rate` of its clock; null: nothing is to be said. In a recording only what is late is. */
export function sceneAge(age: number, rate: number, recorded: boolean): ShownAge | null {
  const late = age > LATE_S * Math.max(1, rate);
  if (!Number.isFinite(age) || (recorded && !late)) return null;
  const text = late
    ? t("{age} s", { age: number(age, 1) })
    : t("{count} ms", { count: 10 * Math.round(100 * Math.max(0, age)) });
  return { text, late, title: titled("Age of the 3D view: since the robot was where you see it.", late) };
}

function titled(meaning: Text, late: boolean): string {
  return late ? t("{meaning} What you do now comes later still: drive slowly.", { meaning: t(meaning) }) : t(meaning);
}
