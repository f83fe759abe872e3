/** From what the robot perceives of people to what is drawn and said of it. Pure. */

import { decimals, listed, plural, t } from "../i18n";
import type { HeardSound, Perceived, SeenFace } from "../protocol/types";

/** A disc is gone so long after its sound fell silent, a flash so long after its noise, s. */
export const FADE_S = 1.5;
export const FLASH_S = 0.7;
/** Probability from which a sound is shown as a voice; the same as in the 3D view. */
const VOICE = 0.5;
const LEVELS_DB = [-65, -15] as const;
/** Of a face, m. */
const FACE = { width: 0.2, height: 0.26 };
const UNKNOWN_RANGE_M = 2;
/** A distance is shown if its standard deviation is below this share of it. */
const KNOWN = 0.5;

export type SoundKind = "voice" | "sound" | "unjudged";

/** Angles in rad. */
export interface FaceMark {
  track: number;
  azimuth: number;
  elevation: number;
  width: number;
  height: number;
  range: number | null;
  text: string;
  /** Without the distance. */
  short: string;
}

export interface SoundMark {
  track: number;
  azimuth: number;
  elevation: number;
  kind: SoundKind;
  active: boolean;
  /** 0 to 1: of the softest to the loudest. */
  loudness: number;
  /** 1 while it sounds. */
  opacity: number;
  text: string;
}

/** Each person once, as the camera saw them that knows their distance best; the nearest last, over the others. */
export function faceMarks(perceived: Perceived | null): FaceMark[] {
  const best = new Map<number, SeenFace>();
  for (const face of perceived?.faces ?? []) {
    const before = best.get(face.track);
    if (!before || (face.range_sigma_m ?? Infinity) < (before.range_sigma_m ?? Infinity)) best.set(face.track, face);
  }
  return [...best.values()]
    .sort((a, b) => (b.range_m ?? Infinity) - (a.range_m ?? Infinity))
    .map((face) => {
      const range = Math.max(0.3, face.range_m ?? UNKNOWN_RANGE_M);
      return {
        track: face.track,
        ...whereOf(face),
        width: FACE.width / range,
        height: FACE.height / range,
        range: face.range_m,
        text: personWords(face),
        short: t("Person {track}", { track: face.track }),
      };
    });
}

/** What sounds, and what did lately; the loudest last, over the others. */
export function soundMarks(perceived: Perceived | null, now: number): SoundMark[] {
  return (perceived?.sounds ?? [])
    .flatMap((sound) => {
      const opacity = sound.active ? 1 : Math.min(1, 1 - (now - sound.last_active) / FADE_S);
      if (opacity <= 0) return [];
      const loudness = (sound.level_db - LEVELS_DB[0]) / (LEVELS_DB[1] - LEVELS_DB[0]);
      return {
        track: sound.track,
        ...whereOf(sound),
        kind: kindOf(sound),
        active: sound.active,
        loudness: Math.max(0, Math.min(1, loudness)),
        opacity,
        text: soundWords(sound),
      };
    })
    .sort((a, b) => a.loudness - b.loudness);
}

/** How much of the last noise's flash is left, 1 to 0. */
export function flash(perceived: Perceived | null, now: number): number {
  const last = perceived?.noises.at(-1);
  return last ? Math.max(0, Math.min(1, 1 - (now - last.stamp) / FLASH_S)) : 0;
}

export function kindOf(sound: HeardSound): SoundKind {
  if (sound.speech === null) return "unjudged";
  return sound.speech >= VOICE ? "voice" : "sound";
}

export function personWords(face: SeenFace): string {
  return face.range_m === null
    ? t("Person {track}", { track: face.track })
    : t("Person {track}, {range} m", { track: face.track, range: decimals(face.range_m.toFixed(1)) });
}

export function soundWords(sound: HeardSound): string {
  const what = kindOf(sound) === "voice" ? t("voice") : t("sound");
  const { range_m, range_sigma_m } = sound;
  const known = range_m !== null && (range_sigma_m ?? Infinity) <= KNOWN * range_m;
  return known ? `${what}, ${decimals(range_m.toFixed(1))} m` : what;
}

/** "ahead", "30° left", "behind". */
export function directionWords(azimuth: number): string {
  const degrees = Math.round((Math.abs(azimuth) * 180) / Math.PI / 5) * 5;
  if (degrees < 5) return t("ahead");
  if (degrees > 170) return t("behind");
  return azimuth > 0 ? t("{degrees}° left", { degrees }) : t("{degrees}° right", { degrees });
}

/** "2 people, 1 voice at 30° left"; empty where there is nothing. */
export function summary(faces: FaceMark[], sounds: SoundMark[], noise: boolean): string {
  const parts = [];
  if (faces.length > 0)
    parts.push(
      faces.length === 1
        ? t("1 person {where}", { where: at(faces) })
        : plural(faces.length, "{count} person", "{count} people"),
    );
  const active = sounds.filter((sound) => sound.active);
  const voices = active.filter((sound) => sound.kind === "voice");
  const others = active.filter((sound) => sound.kind !== "voice");
  if (voices.length > 0) parts.push(`${plural(voices.length, "{count} voice", "{count} voices")} ${at(voices)}`);
  if (others.length > 0) parts.push(`${plural(others.length, "{count} sound", "{count} sounds")} ${at(others)}`);
  if (noise) parts.push(t("a loud noise"));
  return parts.join(", ");
}

function at(marks: { azimuth: number }[]): string {
  const words = marks.map(({ azimuth }) => directionWords(azimuth));
  const joined = listed(words);
  return /^\d/.test(joined) ? t("at {angles}", { angles: joined }) : joined;
}

/** Where it is seen from the panorama's camera, so that it lies on the picture; else from its own sensor. */
function whereOf(percept: SeenFace | HeardSound): { azimuth: number; elevation: number } {
  const [azimuth, elevation] = percept.panorama ?? [percept.azimuth, percept.elevation];
  return { azimuth, elevation };
}
