/** Where the robot is, where it goes and why not, in plain words. Pure. */

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
  if (goal?.name && apart(at, goal) <= NEAR_M) return goal.name;
  const place = places.find((one) => apart(at, one) < START_M);
  if (place) return place.name;
  return Math.hypot(at.x, at.y) < START_M ? "the start" : `(${coordinate(at.x)}, ${coordinate(at.y)})`;
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
    const why = sentence(reason) || "It cannot be reached.";
    return { tone: "bad", text: `Gave up on ${placeWords(place, places)}`, more: why, over: true };
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
        text: `Not going to ${placeWords(goal, places, goal)}`,
        more: sentence(reasonText(lane.state, lane.text)),
      };
    return { tone: "busy", text: `Setting out for ${placeWords(goal, places, goal)}…`, more: "" };
  }
  if (!current) return null;
  const reason = sentence(current.reason);
  const away = current.target ? apart(current.target, to) : 0;
  const nearest =
    away > NEAR_M ? `The goal itself cannot be reached: the robot stops ${number(away, 1)} m from it.` : "";
  switch (current.state) {
    case "planning":
      return { tone: "busy", text: `Planning a path to ${where}…`, more: "" };
    case "following":
      return { tone: "good", text: `Going to ${where}${leftWords(current.remaining_m)}`, more: reason || nearest };
    case "recovering":
      // While it is freeing itself, it has counted that.
      if (place?.state === "lost" || place?.state === "searching" || current.recoveries === 0)
        return { tone: "warn", text: `Localizing, then going to ${where}`, more: reason };
      return { tone: "warn", text: `Stuck on the way to ${where}${attempts(current.recoveries)}`, more: reason };
    case "waiting":
      return { tone: "warn", text: `Waiting on the way to ${where}${leftWords(current.remaining_m)}`, more: reason };
    case "unreachable":
      return { tone: "bad", text: `No path to ${where}`, more: reason };
    case "arrived":
      return {
        tone: "good",
        text: `Arrived at ${where}`,
        more: nearest && `${number(away, 1)} m from the goal, which cannot be reached.`,
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
  const map = name || "a new map";
  if (slam && slam.divisor === null)
    return { tone: "warn", text: `Last pose on ${map}`, more: "SLAM is off: the pose comes from odometry alone." };
  const [sx, sy, st] = localization.sigma;
  const unsure = `±${lengthWords(Math.max(sx, sy))}, ±${number((st * 180) / Math.PI, 1)}°`;
  switch (localization.state) {
    case "mapping":
      return {
        tone: "good",
        text: name ? `Extending ${map}` : "Mapping, not saved yet",
        more: unsure,
      };
    case "tracking":
      return { tone: "good", text: `On the map ${map}`, more: unsure };
    case "searching":
      return {
        tone: "warn",
        text: `Searching for its pose on ${map}`,
        more: "Drive it around a little, or set its pose.",
      };
    case "lost":
      return {
        tone: "bad",
        text: `Lost on ${map}`,
        more: "The laser scan does not fit the map. Set its pose, or press Search.",
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
  if (replay && !localization) return { text: "No map at this time of the recording.", more: "", desire: false };
  if (!live) return { text: "No map yet.", more: "The robot does not answer.", desire: false };
  if (!slam)
    return {
      text: "No map: this program does no mapping.",
      more: "Its configuration has no strategy for SLAM.",
      desire: false,
    };
  if (slam.divisor === null && slam.state !== "fulfilled" && slam.state !== "degraded")
    return {
      text: "No map yet: SLAM is not running.",
      more:
        slam.state === "undesired"
          ? "There is no desire for it. Press Start mapping, or set a goal."
          : sentence(reasonText(slam.state, slam.text)),
      desire: slam.state === "undesired",
    };
  return { text: "Waiting for the first map…", more: "", desire: false };
}

/** What the tool in hand does, and what the keys do while the cursor is theirs; `stands`: Escape stops nothing. */
export function hintWords({ tool, act, cursor, corners }: Tools, stands: boolean): string {
  const up = stands ? "Esc cancels" : "⌫ cancels";
  const away = stands && tool !== "look" ? ", Esc puts the tool away" : "";
  if (act.kind === "aim" && act.by === "keys") {
    const turn = act.heading === null ? "Arrows set the heading" : "← → turn it";
    return `${turn}, Enter ${tool === "pose" ? "sets it" : "sends it"}, ${up}.`;
  }
  if (tool === "keep_out" || tool === "slow") {
    if (!cursor) return "Drag a rectangle, or click corner after corner.";
    const close = corners.length >= 3 ? ", the first corner again closes the zone" : "";
    return `Arrows move the cursor, Enter sets a corner${close}, ${corners.length > 0 ? "⌫ removes the last one" : up}.`;
  }
  if (tool === "point") return cursor ? `Arrows move the cursor, Enter takes the point${away}.` : "Click on the point.";
  if (cursor) return `Arrows move the cursor, Enter puts ${tool === "pose" ? "the robot" : "a goal"} there${away}.`;
  if (tool === "goal") return "Press on the goal, drag to set the heading.";
  return tool === "pose" ? "Press on the robot's place, drag to set its heading." : "";
}

/** "4 cm", "1.2 m". */
export function lengthWords(metres: number): string {
  return metres < 0.995 ? `${number(metres * 100, 0)} cm` : `${number(metres, 1)} m`;
}

function isOld(navigation: Navigation, now: number | null): boolean {
  return now !== null && now - navigation.stamp > ARRIVED_S;
}

function leftWords(metres: number | null): string {
  return metres === null ? "" : `, ${metres.toFixed(1)} m left`;
}

function coordinate(metres: number): string {
  return metres.toFixed(1).replace("-", "−");
}

function attempts(count: number): string {
  return count > 1 ? `: recovery ${count}` : ": recovering";
}

function apart(a: { x: number; y: number }, b: { x: number; y: number }): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
