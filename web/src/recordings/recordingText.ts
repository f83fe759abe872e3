/** What the Recorder does, in words and figures; pure. */

import { t } from "../i18n";
import type { Recorder, Recording } from "../protocol/types";

/** Seconds recorded until `now`: counts on between the Recorder's reports. */
export function recordedFor(recorder: Recorder, now: number | null): number {
  if (recorder.state !== "recording" || now === null || recorder.began === null) return recorder.duration_s;
  const since = now - recorder.began;
  return Math.abs(since - recorder.duration_s) < 3 ? since : recorder.duration_s;
}

/** Newest first; those of no known time last, by name. */
export function newestFirst(recordings: readonly Recording[]): Recording[] {
  return [...recordings].sort(
    (a, b) => (b.began ?? -Infinity) - (a.began ?? -Infinity) || a.name.localeCompare(b.name),
  );
}

/** Where a replay opens: without the 3D view, if this page shows none. `from` is this page's own address. */
export function replayAddress(url: string, from: string, scene: boolean): string {
  const address = new URL(url, from);
  if (!scene) address.searchParams.set("scene", "off");
  return address.href;
}

const LONGEST_RING = 120;
const NAME = /^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$/;

/** What is wrong with a recording's name; empty: nothing. No name is fine: the robot makes one of the time. */
export function nameProblem(name: string): string {
  if (name === "" || NAME.test(name)) return "";
  if (!/^[A-Za-z0-9]/.test(name)) return t("Begins with a letter or a digit.");
  if (name.length > 100) return t("At most 100 characters.");
  return t("No spaces: letters, digits, dots, - and _ only.");
}

/** Minutes of a ring as typed: a number, null for none, or what is wrong. */
export function ringMinutes(text: string): number | null | string {
  const trimmed = text.replace(",", ".").trim();
  if (trimmed === "") return null;
  const minutes = Number(trimmed);
  return minutes > 0 && minutes <= LONGEST_RING ? minutes : t("Minutes, over 0 to {most}.", { most: LONGEST_RING });
}
