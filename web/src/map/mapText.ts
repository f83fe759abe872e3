/** Where the robot is, where it goes and why not, in plain words. Pure. */

import { decimals, named, t } from "../i18n";
import type { Desire, GoalPlace, LaneRow, LocalizationReport, Navigation, Place } from "../protocol/types";
import { number, reasonText, sentence } from "../ui/format";
import type { Tools } from "./mapTools";

export type Tone = "good" | "busy" | "warn" | "bad" | "idle";

export interface Phrase {
  tone: Tone;
  text: string;
  /** More of it, or what would help; empty: nothing. */
  more: string;
  /** It is over, and stays until it was read. */
  over?: boolean;
}

/** A goal as it is desired. */
export interface Goal extends GoalPlace {
  /** Of its desire. */
  id: string;
  /** Asked for over the console, by people or programs. */
  asked: boolean;
  /** What the place is called that it was given by; empty: it was given by coordinates. */
  name: string;
}

const CLASS = "GoTo";
export const EXPLORE = "Explore";
const ASKED = new Set(["operator", "rest"]);
const NEAR_M = 0.1;
/** So long an arrival is news. */
const ARRIVED_S = 30;
const START_M = 0.05;

/** The goal that speaks for its class: of the most intense desire, the newest. */
export function goalOf(desires: readonly Desire[] | null | undefined): Goal | null {
  const strongest = tripsOf(desires)[0];
  if (!strongest) return null;
  const { x, y, heading, name } = strongest.params;
  if (typeof x !== "number" || typeof y !== "number") return null;
  const theta = typeof heading === "number" ? heading : null;
  return { x, y, theta, id: strongest.id, asked: isAsked(strongest), name: typeof name === "string" ? name : "" };
}

/** Everything that sends the robot anywhere, what speaks for the class first: of it, the next takes over. */
export function tripsOf(desires: readonly Desire[] | null | undefined): Desire[] {
  return (desires ?? [])
    .filter((desire) => desire.class === CLASS && desire.utility > 0)
    .sort((a, b) => b.intensity - a.intensity || Number(b.security) - Number(a.security) || b.created - a.created);
}

/** What has the robot explore: it sets out for one place after another by itself. */
export function explorationsOf(desires: readonly Desire[] | null | undefined): Desire[] {
  return (desires ?? []).filter((desire) => desire.class === EXPLORE && desire.utility > 0);
}

/** Whether it was asked for over the console, by people or programs. */
export function isAsked({ source }: Desire): boolean {
  return ASKED.has(source.kind);
}

/** "Robotics lab", "the start", "(3.2, −1)"; `goal`: what was desired, which may have a name. */
export function placeWords(
  at: { x: number; y: number },
  places: readonly Place[] = [],
  goal: Goal | null = null,
): string {
  if (goal?.name && apart(at, goal) <= NEAR_M) return named(goal.name);
  const place = places.find((one) => apart(at, one) < START_M);
  if (place) return place.name;
  return Math.hypot(at.x, at.y) < START_M
    ? t("the start")
    : t("({x}, {y})", { x: coordinate(at.x), y: coordinate(at.y) });
}

/**
 * The state of the trip in words; null: there is none. `place`: where
 * the robot believes to be, since one that does not know is not stuck. A goal
 * at one of `places` is called as it is.
 */
export function wayWords(
  navigation: Navigation | null,
  goal: Goal | null,
  rows: readonly LaneRow[],
  now: number | null = null,
  place: LocalizationReport | null = null,
  places: readonly Place[] = [],
): Phrase | null {
  if (!goal && navigation?.given_up) {
    const { goal: place, reason } = navigation.given_up;
    const why = sentence(reason) || t("It cannot be reached.");
    return { tone: "bad", text: t("Gave up on {place}", { place: placeWords(place, places) }), more: why, over: true };
  }
  const lane = rows.find((row) => row.class === CLASS);
  const past = navigation?.state === "idle" || (navigation?.state === "arrived" && !goal && isOld(navigation, now));
  const current = past ? null : navigation;
  const to = current?.goal ?? goal;
  if (!to) return null;
  const where = placeWords(to, places, goal);
  // Of a new goal the behavior has not spoken yet, or attention has given it nothing.
  if (goal && (!current?.goal || apart(current.goal, goal) > NEAR_M)) {
    if (lane && (lane.state === "unfulfilled" || lane.state === "inhibited"))
      return {
        tone: "warn",
        text: t("Not going to {goal}", { goal: placeWords(goal, places, goal) }),
        more: sentence(reasonText(lane.state, lane.text)),
      };
    return { tone: "busy", text: t("Setting out for {goal}…", { goal: placeWords(goal, places, goal) }), more: "" };
  }
  if (!current) return null;
  const reason = sentence(current.reason);
  const away = current.target ? apart(current.target, to) : 0;
  const nearest =
    away > NEAR_M
      ? t("The goal itself cannot be reached: the robot stops {away} m from it.", { away: number(away, 1) })
      : "";
  switch (current.state) {
    case "planning":
      return { tone: "busy", text: t("Planning a path to {where}…", { where }), more: "" };
    case "following":
      return {
        tone: "good",
        text: t("Going to {where}{left}", { where, left: leftWords(current.remaining_m) }),
        more: reason || nearest,
      };
    case "recovering":
      // While it is freeing itself, it has counted that.
      if (place?.state === "lost" || place?.state === "searching" || current.recoveries === 0)
        return { tone: "warn", text: t("Localizing, then going to {where}", { where }), more: reason };
      return {
        tone: "warn",
        text: t("Stuck on the way to {where}{attempts}", { where, attempts: attempts(current.recoveries) }),
        more: reason,
      };
    case "waiting":
      return {
        tone: "warn",
        text: t("Waiting on the way to {where}{left}", { where, left: leftWords(current.remaining_m) }),
        more: reason,
      };
    case "unreachable":
      return { tone: "bad", text: t("No path to {where}", { where }), more: reason };
    case "arrived":
      return {
        tone: "good",
        text: t("Arrived at {where}", { where }),
        more: nearest && t("{away} m from the goal, which cannot be reached.", { away: number(away, 1) }),
      };
    case "idle":
      return null;
  }
}

/**
 * Where the robot believes to be; `slam`: the lane of the class SLAM, whose filter is closed while SLAM is off; `name`: of
 * the map in use, where it is known better than by the last scan.
 */
export function poseWords(localization: LocalizationReport, slam?: LaneRow, name: string = localization.map): Phrase {
  const map = name || t("a new map");
  if (slam && slam.divisor === null)
    return {
      tone: "warn",
      text: t("Last pose on {map}", { map }),
      more: t("SLAM is off: the pose comes from odometry alone."),
    };
  const [sx, sy, st] = localization.sigma;
  const unsure = `±${lengthWords(Math.max(sx, sy))}, ±${number((st * 180) / Math.PI, 1)}°`;
  switch (localization.state) {
    case "mapping":
      return {
        tone: "good",
        text: name ? t("Extending {map}", { map }) : t("Mapping, not saved yet"),
        more: unsure,
      };
    case "tracking":
      return { tone: "good", text: t("On the map {map}", { map }), more: unsure };
    case "searching":
      return {
        tone: "warn",
        text: t("Searching for its pose on {map}", { map }),
        more: t("Drive it around a little, or set its pose."),
      };
    case "lost":
      return {
        tone: "bad",
        text: t("Lost on {map}", { map }),
        more: t("The laser scan does not fit the map. Set its pose, or press Search."),
      };
  }
}

/** Why there is no map to see; `slam`: the lane of the class SLAM, `modules`: whether a module makes maps at all. */
export function emptyWords(
  live: boolean,
  replay: boolean,
  slam: LaneRow | undefined,
  localization: LocalizationReport | null,
): { text: string; more: string; desire: boolean } {
  if (replay && !localization) return { text: t("No map at this time of the recording."), more: "", desire: false };
  if (!live) return { text: t("No map yet."), more: t("The robot does not answer."), desire: false };
  if (!slam)
    return {
      text: t("No map: this program does no mapping."),
      more: t("Its configuration has no strategy for SLAM."),
      desire: false,
    };
  if (slam.divisor === null && slam.state !== "fulfilled" && slam.state !== "degraded")
    return {
      text: t("No map yet: SLAM is not running."),
      more:
        slam.state === "undesired"
          ? t("There is no desire for it. Press Start mapping, or set a goal.")
          : sentence(reasonText(slam.state, slam.text)),
      desire: slam.state === "undesired",
    };
  return { text: t("Waiting for the first map…"), more: "", desire: false };
}

/** What the tool in hand does, and what the keys do while the cursor is theirs; `stands`: Escape stops nothing. */
export function hintWords({ tool, act, cursor, corners }: Tools, stands: boolean): string {
  const up = stands ? t("Esc cancels") : t("⌫ cancels");
  const away = stands && tool !== "look" ? t(", Esc puts the tool away") : "";
  if (act.kind === "aim" && act.by === "keys") {
    const turn = act.heading === null ? t("Arrows set the heading") : t("← → turn it");
    return `${turn}, ${tool === "pose" ? t("Enter sets it") : t("Enter sends it")}, ${up}.`;
  }
  if (tool === "keep_out" || tool === "slow") {
    if (!cursor) return t("Drag a rectangle, or click corner after corner.");
    const close = corners.length >= 3 ? t(", the first corner again closes the zone") : "";
    const back = corners.length > 0 ? t("⌫ removes the last one") : up;
    return t("Arrows move the cursor, Enter sets a corner{close}, {back}.", { close, back });
  }
  if (tool === "point")
    return cursor ? t("Arrows move the cursor, Enter takes the point{away}.", { away }) : t("Click on the point.");
  if (cursor)
    return tool === "pose"
      ? t("Arrows move the cursor, Enter puts the robot there{away}.", { away })
      : t("Arrows move the cursor, Enter puts a goal there{away}.", { away });
  if (tool === "goal") return t("Press on the goal, drag to set the heading.");
  return tool === "pose" ? t("Press on the robot's place, drag to set its heading.") : "";
}

/** "4 cm", "1.2 m". */
export function lengthWords(metres: number): string {
  return metres < 0.995 ? t("{centimetres} cm", { centimetres: number(metres * 100, 0) }) : `${number(metres, 1)} m`;
}

function isOld(navigation: Navigation, now: number | null): boolean {
  return now !== null && now - navigation.stamp > ARRIVED_S;
}

function leftWords(metres: number | null): string {
  return metres === null ? "" : t(", {metres} m left", { metres: decimals(metres.toFixed(1)) });
}

function coordinate(metres: number): string {
  return decimals(metres.toFixed(1)).replace("-", "−");
}

function attempts(count: number): string {
  return count > 1 ? t(": recovery {count}", { count }) : t(": recovering");
}

function apart(a: { x: number; y: number }, b: { x: number; y: number }): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
