/** What an operator has the robot do by a press: gestures and expressions, as desires. Pure. */

import type { DesireClass, NewDesire } from "../protocol/types";

interface Scale {
  intensity: number;
  utility: number;
}

export interface Act {
  title: string;
  desire: NewDesire;
}

/** How long (s) an expression stays, a gesture may take, and a sentence may wait. */
const EXPRESSED_S = 20;
const GESTURE_S = 20;
const SENTENCE_S = 60;
const EXPRESSIONS = ["happy", "sad", "angry", "calm"];
/** A gesture of the class, in words. */
const GESTURES: readonly (readonly [cls: string, title: string])[] = [
  ["Wave", "Wave"],
  ["Rest", "Arms down"],
  ["LookAround", "Look around"],
];

/** The acts that this robot can do. */
export function acts(classes: readonly DesireClass[], scale: Scale): Act[] {
  const served = new Set(classes.filter((each) => each.served).map(({ name }) => name));
  const expressions = served.has("Express")
    ? EXPRESSIONS.map((expression) => ({
        title: capital(expression),
        desire: wish("Express", { expression }, EXPRESSED_S, scale),
      }))
    : [];
  const gestures = GESTURES.filter(([cls]) => served.has(cls)).map(([cls, title]) => ({
    title,
    desire: wish(cls, {}, GESTURE_S, scale),
  }));
  return [...gestures, ...expressions];
}

/** The desire to say `text`. */
export function say(text: string, scale: Scale): NewDesire {
  return wish("Say", { text }, SENTENCE_S, scale);
}

function wish(cls: string, params: Record<string, unknown>, ttl: number, scale: Scale): NewDesire {
  return { class: cls, intensity: scale.intensity, utility: 1, security: false, params, ttl } as NewDesire;
}

function capital(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}
