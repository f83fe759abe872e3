/** What can be done with a recording that is shown: keys and figures, pure. */

import { decimals, plural, t } from "../i18n";
import type { Playback } from "../protocol/types";

export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8] as const;
export const SKIP_S = 5;
/** Back by as much as a step forward usually is: one message of the fastest channels. */
export const BACK_S = 0.1;

export type Action = "toggle" | "step" | "back" | "skip" | "rewind" | "begin" | "end";

const KEYS: Readonly<Record<string, Action>> = {
  Space: "toggle",
  Period: "step",
  Comma: "back",
  ArrowRight: "skip",
  ArrowLeft: "rewind",
  Home: "begin",
  End: "end",
};
/** Codes of the keys that move a recording. */
export const PLAYBACK_KEYS: readonly string[] = Object.keys(KEYS);

export interface Key {
  code: string;
  /** It types into a field. */
  typing: boolean;
  /** The focus is on something with a use of its own for arrows (lanes, tabs), or for Space (a button). */
  ownsArrows: boolean;
  pressable: boolean;
}

export function actionOf(key: Key): Action | null {
  const action = KEYS[key.code];
  if (!action || key.typing) return null;
  if (key.code === "Space") return key.pressable ? null : action;
  if (/^(Arrow|Home|End)/.test(key.code) && key.ownsArrows) return null;
  return action;
}

/** Where `action` leads from `position`, or null if it does not move the position by itself. */
export function target(
  action: Action,
  position: number,
  { begin, end }: Pick<Playback, "begin" | "end">,
): number | null {
  const to = {
    toggle: null,
    step: null,
    back: position - BACK_S,
    skip: position + SKIP_S,
    rewind: position - SKIP_S,
    begin,
    end,
  }[action];
  return to === null ? null : Math.max(begin, Math.min(end, to));
}

/** "1 minute 2 seconds", for those who hear the page. */
export function spokenSpan(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60), whole % 60];
  const parts = [
    h > 0 && plural(h, "{count} hour", "{count} hours"),
    m > 0 && plural(m, "{count} minute", "{count} minutes"),
    s > 0 && plural(s, "{count} second", "{count} seconds"),
  ];
  return parts.filter(Boolean).join(" ") || t("the beginning");
}

export function speedWord(speed: number | null): string {
  return speed === null ? "max" : `${decimals(String(speed))}×`;
}

/** The pace a recording has, where it is not the one asked for: the computer cannot do more. */
export function slowerThanAsked(playback: Pick<Playback, "speed" | "playing">, rate: number): boolean {
  return playback.playing && playback.speed !== null && rate > 0 && rate < 0.9 * playback.speed;
}

/** Whether stamps are times of day, and not seconds from some start. */
export function isDated(stamp: number): boolean {
  return stamp > 1e8;
}
