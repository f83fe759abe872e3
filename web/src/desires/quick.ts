/** Desires that one press adds, and a desire as a command for a shell. Pure. */

import { type Text, t } from "../i18n";
import type { DesireClass, NewDesire } from "../protocol/types";
import { offered } from "./schema";

export interface Quick {
  title: string;
  desire: NewDesire & { ttl: number };
}

/** What people try first, for a while: as much desired as a person's wish, over what the robot wants by itself. */
const CHOICES: readonly (readonly [cls: string, title: Text, ttl: number])[] = [
  ["LocateVoices", "Listen for voices", 30],
  ["LocateFaces", "Look for faces", 60],
  ["ClassifySounds", "Name sounds", 60],
  ["DetectDarkness", "Notice darkness", 60],
];

/** Those that this robot can serve; `limit` is the scale of intensity and of utility. */
export function quick(classes: readonly DesireClass[], limit: { intensity: number; utility: number }): Quick[] {
  const served = new Set(offered(classes).map(({ name }) => name));
  return CHOICES.filter(([cls]) => served.has(cls)).map(([cls, title, ttl]) => ({
    title: `${t(title)}, ${ttl} s`,
    desire: { class: cls, intensity: limit.intensity, utility: limit.utility / 2, security: false, params: {}, ttl },
  }));
}

/** The command that adds `desire` at the console `address`; `locked`: it needs the token, taken from `HBBA_TOKEN`. */
export function curl(address: string, desire: object, locked: boolean): string {
  const url = new URL("./api/v1/desires", address).href;
  const login = locked ? ' -H "Authorization: Bearer $HBBA_TOKEN"' : "";
  return `curl -X POST ${url} -H 'Content-Type: application/json'${login} -d ${quoted(JSON.stringify(desire))}`;
}

/** As one word of a POSIX shell. */
function quoted(text: string): string {
  return `'${text.replaceAll("'", `'\\''`)}'`;
}
