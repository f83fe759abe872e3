/** Why no people or sounds are perceived: sensors that the robot lacks, and filters that attention has closed. Pure. */

import { t } from "../i18n";
import type { Hello, LaneRow } from "../protocol/types";
import { reasonText, sentence } from "../ui/format";

export interface Closed {
  what: "picture" | "faces" | "voices";
  /** In short: "Faces are not looked for". */
  text: string;
  /** Attention's own words, or why there can be none. */
  reason: string;
}

const PERCEPTIONS = [
  {
    what: "faces",
    kind: "LocateFaces",
    closed: "Face detection is off",
    missing: "This robot does not detect faces",
  },
  {
    what: "voices",
    kind: "LocateVoices",
    closed: "Sound localization is off",
    missing: "This robot does not localize sounds",
  },
] as const;

/** Whether anything can ever be shown of what is around: a picture, faces or voices. */
export function perceives(hello: Hello | null): boolean {
  if (!hello || hello.playback || hello.channels.panorama) return true;
  return PERCEPTIONS.some(({ kind }) => hello.classes.some(({ name, served }) => name === kind && served));
}

/** `fresh`: the picture is of now. In a replay attention closes nothing to those who watch. */
export function whyClosed(hello: Hello | null, rows: LaneRow[], replay: boolean, fresh: boolean): Closed[] {
  if (!hello) return [];
  const lane = (kind: string) => rows.find((row) => row.class === kind);
  const closed: Closed[] = [];
  if (!hello.channels.panorama)
    closed.push({
      what: "picture",
      text: replay ? t("This recording has no panorama") : t("This robot has no panoramic camera"),
      reason: "",
    });
  else {
    const telepresence = lane("Telepresence");
    if (!fresh && !replay && telepresence && telepresence.divisor === null)
      closed.push({ what: "picture", text: t("No picture"), reason: reasonOf(telepresence) });
  }
  if (rows.length === 0) return closed;
  for (const { what, kind, closed: text, missing } of PERCEPTIONS) {
    const row = lane(kind);
    const served = replay || hello.classes.find(({ name }) => name === kind)?.served !== false;
    if (!row || !served) closed.push({ what, text: t(missing), reason: "" });
    else if (row.divisor === null) closed.push({ what, text: t(text), reason: reasonOf(row) });
  }
  return closed;
}

function reasonOf(row: LaneRow): string {
  return sentence(reasonText(row.state, row.text));
}
