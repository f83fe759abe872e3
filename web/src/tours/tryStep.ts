/** What a step does, as desires to try it now; pure. */

import type { NewDesire, Step } from "../protocol/types";
import { textOf } from "./tourEdits";

/** Long enough to say the longest text, short enough to be forgotten. */
const SAY_S = 180;
const DO_S = 30;

export interface Trial {
  language: string;
  /** Where the step has no text in `language`. */
  fallback: string;
  /** Text of the stop's poster; null: it has none. */
  poster: string | null;
  /** Whether this program does anything for a class of desires. */
  serves: (kind: string) => boolean;
}

/** To look at visitors depends on where they are, and is left to the guide. */
export function desiresOf(step: Step, { language, fallback, poster, serves }: Trial): NewDesire[] {
  const found: NewDesire[] = [];
  const add = (kind: string, params: Record<string, unknown>, ttl: number) => {
    if (serves(kind)) found.push({ class: kind, intensity: 6, utility: 1, params, ttl });
  };
  const onMap = ([x, y, z]: readonly [number, number, number]) => ({ x, y, z, frame: "map" });
  if (step.say) {
    const used = step.say[language] ? language : fallback;
    add("Say", { text: textOf(step.say, [language, fallback]), language: used }, SAY_S);
  }
  if (Array.isArray(step.look)) add("LookAt", onMap(step.look), DO_S);
  if (step.look === "poster" && poster) add("LookAt", { place: poster }, DO_S);
  if (step.point) add("PointAt", onMap(step.point), DO_S);
  if (step.gesture) add(step.gesture.class, step.gesture.params, DO_S);
  if (step.expression) add("Express", { expression: step.expression }, DO_S);
  return found;
}
