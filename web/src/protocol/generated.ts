/**
 * What crosses the live stream and REST. Written by `make types` from the Python records; change those, not this file.
 * Stamps are the robot's clock, in seconds.
 */

import type { JsonSchema } from "./jsonSchema";

/** A behavior's report that what a desire asks for is done, or that it cannot be done. */
export interface Accomplishment {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  desire_id: string;
  /** Name of the module that reports it. */
  behavior: string;
  outcome: "done" | "failed";
  /** In words: what was reached, or why it cannot be; may be empty. */
  reason: string;
}

/** A change that would serve a desire better: more of a resource, or no desire for another class. */
export interface Alternative {
  kind: "capacity" | "without";
  /** The utility that the class would get. */
  utility: number;
  /** Of `capacity`: the resource; else empty. */
  resource: string;
  /** Of `capacity`: how much more of it. */
  amount: number;
  unit: string;
  /** Of `without`: the other class; else empty. */
  without: string;
}

/** An event that is to come, by the episode that is recognized. */
export interface AnticipatedEvent {
  event: MemoryEvent;
  /** In the episode, over 0 and at most 1: the later, the greater. */
  weight: number;
}

/** What the strongest desire of a class asked for, when the problem was solved. */
export interface Asked {
  /** With what an emotion added. */
  intensity: number;
  utility: number;
  security: boolean;
  /** What an emotion added to the intensity; null: nothing. */
  modulation: Modulation | null;
}

/** Who asks the driver for the wheel. */
export interface Asker {
  operator: string;
  /** Whether it is this page's operator. */
  mine: boolean;
  /** Until the driver has not answered. */
  remaining_s: number;
}

/** Whether the robot has microphones to listen to, and a loudspeaker to speak through. */
export interface AudioFacts {
  listen: boolean;
  speak: boolean;
}

/**
 * Limits of the mobile base: speeds (m/s, rad/s) and accelerations (m/s^2, rad/s^2), all positive. ``lateral_mps`` is
 * the greatest speed sideways, 0 for a base that cannot move so (a differential drive). Forward and sideways speeds are
 * limited together, as a vector within the ellipse of both limits; its change is within ``linear_mps2``.
 */
export interface BaseLimits {
  linear_mps: number;
  angular_radps: number;
  linear_mps2: number;
  angular_radps2: number;
  lateral_mps: number;
}

/** How much charge a tour needs, as shares of a full battery. */
export interface BatteryRule {
  /** No tour begins below this. */
  begin_min: number;
  /** Below this, the tour ends at once. */
  end_below: number;
}

/** State of the body's battery. */
export interface BatteryState {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** Share of the capacity that is left, 0 to 1. */
  charge: number;
  /** At its terminals, V. */
  voltage_v: number;
  /** Into the battery, A: negative while it discharges. */
  current_a: number;
  /** Whether a charger supplies power, also once the battery is full. */
  charging: boolean;
  /** Time until it is empty, or full while it charges, at the mean power of the last minute; null: neither. */
  remaining_s: number | null;
}

/** When people are invited. */
export interface Begin {
  /** What begins it: a press, a face, a voice. */
  by: ("press" | "face" | "voice")[];
  /** At least so many people. */
  people_min: number;
  /** Within so many metres. */
  within_m: number;
  /** For so many seconds. */
  for_s: number;
}

/** A point on the map (m). */
export interface CameraPoint {
  x: number;
  y: number;
  /** Above the floor. */
  z: number;
  /** By the camera's depth; else it is where the ray meets the floor, at most 4 m from the camera. */
  measured: boolean;
}

/**
 * A warning about a program's configuration: a ``title`` of a few words, and a ``text`` of one sentence with the reason
 * and the remedy. ``where``: file and line, "" if unknown.
 */
export interface Caution {
  title: string;
  text: string;
  where: string;
}

/** What attention reckons with of a strategy. */
export interface ChangedStrategy {
  name: string;
  /** Less than declared while a perception works badly. */
  utility: number;
  /** What it uses of each resource. */
  costs: Record<string, number>;
}

/** Whether there are such pictures, scans and clouds. */
export interface Channels {
  camera: boolean;
  panorama: boolean;
  map: boolean;
  costmap: boolean;
  scan: boolean;
  point_cloud: boolean;
}

/** Words by which visitors steer the tour while it is led, by language; without any, presses alone do. */
export interface Commands {
  /** One moment, please. */
  pause: Record<string, string[]>;
  /** These end only a pause that visitors asked for. */
  resume: Record<string, string[]>;
  /** On to the next stop. */
  skip: Record<string, string[]>;
  /** Back to the stop that was skipped. */
  undo_skip: Record<string, string[]>;
  /** The whole stop once more. */
  repeat: Record<string, string[]>;
  /** Goodbye, and home. */
  end: Record<string, string[]>;
}

/** A question before the tour begins, agreed to by a word or a press. */
export interface Confirmation {
  ask: Record<string, string>;
  /** Words that agree, by language; a button is always there. */
  agree: Record<string, string[]>;
  /** Words that decline, by language. */
  decline: Record<string, string[]>;
  /** Seconds after which no answer is a no. */
  at_most_s: number;
}

/** The map in use. */
export interface CurrentMap {
  /** Whether this program makes maps; if not, nothing of this can be asked. */
  available: boolean;
  /** Empty while it has none. */
  name: string;
  /** Of the robot's place on it, as on the live stream; null before it is known. */
  state: "lost" | "mapping" | "searching" | "tracking" | null;
  /** When that was so (robot's clock, s). */
  stamp: number | null;
}

/** One desire of the Intention Workspace. */
export interface Desire {
  id: string;
  class: string;
  /** How much it is desired, over 0 and at most 8. */
  intensity: number;
  /** Utility desired, 0 to 8; 0 inhibits the class. */
  utility: number;
  /** Whether it must be fulfilled. */
  security: boolean;
  /** Parameters as the class declares them. */
  params: Record<string, unknown>;
  source: Source;
  /** Seconds of the robot's clock (Unix epoch). */
  created: number;
  /** When it expires (robot's clock, s); null: never. */
  expires: number | null;
  /** What an emotion adds to its intensity (docs/emotions.md); null: nothing. */
  modulation: Modulation | null;
}

/** What can be desired. */
export interface DesireClassReport {
  name: string;
  title: string;
  description: string;
  /** JSON Schema of `params`. */
  schema: JsonSchema;
  /** Whether a strategy of this program's modules serves it; else no desire for it is fulfilled. */
  served: boolean;
  /** Whether a desire for it leaves by itself once it is accomplished. */
  achievement: boolean;
}

/** Whether a desire is intended and exploited now, and since when it has been so, or not. */
export interface DesireProgress {
  /** Of the desire. */
  id: string;
  /** It is the strongest of its class, and attention selected a strategy for it. */
  intended: boolean;
  /** A behavior's commands for it pass its arbiter; of a perception: what was selected for it works. */
  exploited: boolean;
  /** Since when `intended` is what it is (robot's clock, s); null: since it came. */
  intended_since: number | null;
  /** The same of `exploited`. */
  exploited_since: number | null;
}

/** A desire, and what became of it. */
export interface DesireReport {
  id: string;
  class: string;
  /** How much it is desired, over 0 and at most 8. */
  intensity: number;
  /** Utility desired, 0 to 8; 0 inhibits the class. */
  utility: number;
  /** Whether it must be fulfilled. */
  security: boolean;
  /** Parameters as the class declares them. */
  params: Record<string, unknown>;
  source: Source;
  /** Seconds of the robot's clock (Unix epoch). */
  created: number;
  /** When it expires (robot's clock, s); null: never. */
  expires: number | null;
  /** What an emotion adds to its intensity (docs/emotions.md); null: nothing. */
  modulation: Modulation | null;
  /** What a behavior reported last; without a report, why it left; null: nothing became of it yet. */
  outcome: "done" | "expired" | "failed" | "withdrawn" | null;
  /** Name of the module that reported the outcome; empty: none did. */
  behavior: string;
  /** Of the report, in words. */
  reason: string;
  /** When it left (robot's clock, s); null: it is still desired. */
  ended: number | null;
}

/** Every desire in the Intention Workspace, in the order they came. */
export interface Desires {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  desires: Desire[];
  /**
   * Ids of those that a behavior serves by commands that its arbiter lets through now, or for which a perception works.
   */
  exploited: string[];
  /** The last report on each of `desires` on which there is one. */
  accomplishments: Accomplishment[];
  /** The last that left, at most 5, the newest first. */
  ended: DesireReport[];
  /** Of each of `desires`; empty in recordings of older programs. */
  progress: DesireProgress[];
}

/** Who has the wheel. */
export interface Driver {
  operator: string;
  /** Whether it is this page's operator. */
  mine: boolean;
  /** Whether they hold a drive command just now. */
  holds: boolean;
}

/** One emotion. */
export interface EmotionLevel {
  emotion: "anger" | "fear" | "joy" | "sadness";
  /** 0 to 1. */
  intensity: number;
  /** What has fed it, the greatest share first, at most 5. */
  sources: EmotionSource[];
}

/** A desire class that an emotion comes from. */
export interface EmotionSource {
  class: string;
  /** Its part of the emotion's intensity, over 0 and at most 1. */
  share: number;
  /** Whether it is desired, and not exploited, now. */
  neglected: boolean;
}

/** What is felt; published on change, at most once a second. */
export interface EmotionState {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** Joy, anger, sadness, fear, in this order. */
  emotions: EmotionLevel[];
  /** Whether emotions raise the intensity of desires that are ignored. */
  modulates: boolean;
  /** The desires that are raised now. */
  raised: RaisedIntensity[];
  /** Whether face and voice show what is felt. */
  shows: boolean;
  /** What they show now; null: nothing. */
  shown: ShownEmotion | null;
}

/** An episode in a few words. */
export interface EpisodeSummary {
  id: number;
  /** How often it has happened. */
  times: number;
  /** When it ended first (robot's clock, s). */
  first: number;
  /** When it ended last (robot's clock, s). */
  last: number;
  /** How many it has. */
  events: number;
  /** The firmest of its events, at most 8. */
  items: MemoryItem[];
  /** Classes of desires that led to its accomplishment. */
  deeds: string[];
}

/** Events, oldest first. */
export interface EventList {
  events: TimelineEvent[];
}

/** The robot's face. */
export interface FaceReport {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** Positions (rad) of the actuator group `face`, by joint. */
  joints: Record<string, number>;
}

/** A stop's own failure rules. */
export interface FailureExceptions {
  reach: ReachException;
  present: PresentException;
}

/** What to do on failure, for all stops that do not say otherwise. */
export interface FailureRules {
  reach: ReachRule;
  present: PresentRule;
}

/** What the robot does before it goes home. */
export interface Farewell {
  do: Step[];
}

/** This robot first, then the others in the order of the fleet's file. */
export interface FleetReport {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  robots: FleetRobot[];
}

/** One robot, as its own console answered just now. */
export interface FleetRobot {
  /** Its name in the fleet; empty while it has not answered. */
  name: string;
  /** What kind of robot it is. */
  body: string;
  /** Its own console; empty: this one. */
  url: string;
  /**
   * stopped: its emergency stop is latched; problem: it cannot be driven as it is, or has another's name; refused: its
   * console asks for another login; unreachable: it does not answer.
   */
  state: "problem" | "refused" | "stopped" | "unreachable" | "well";
  /** The state in words, where there is more to say. */
  detail: string;
  /** The operator who drives it. */
  driver: string | null;
  /** The behavior that drives its base. */
  exploited: string | null;
  /** Share of its battery's capacity that is left, 0 to 1; null: not known. */
  charge: number | null;
  simulated: boolean;
}

/** A desire of a class of the body's, such as Wave. */
export interface Gesture {
  /** The desire class, as Wave or Reach. */
  class: string;
  /** Its parameters. */
  params: Record<string, string | boolean | number | null>;
}

/** A goal that the robot has given up. */
export interface GivenUpModel {
  stamp: number;
  goal: GoalPoseModel;
  /** Why, in words. */
  reason: string;
}

/** A goal on the map. */
export interface GoalPoseModel {
  x: number;
  y: number;
  /** null: any heading. */
  theta: number | null;
}

/** What the robot does when visitors come. */
export interface Greeting {
  do: Step[];
  /** Asked after it; none: the tour begins at once. */
  confirm: Confirmation | null;
}

/** What the picture that follows, of the same `seq`, shows. */
export interface GridInfo {
  /** Grows. */
  seq: number;
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** `map` or `odom`. */
  frame: string;
  version: number;
  /** Of a pixel. */
  resolution_m: number;
  /** x, y of the picture's lower left corner. */
  origin: [number, number];
  width: number;
  height: number;
}

/** State of the guard of one group of joints. */
export interface GroupReport {
  /** Its name in the body's file, such as head. */
  group: string;
  /** idle, moving, holding, yielding, refused or silent. */
  state: string;
  /** The same in words, where there is more to say. */
  reason: string;
  /** The behavior that moves it; null: none. */
  exploited: string | null;
  /** The fastest of its joints, as measured. */
  speed_radps: number;
}

/** State of the guard. */
export interface Guard {
  /** idle, driving, stale_command, e_stopped, sensor_failure, waiting or silent. */
  state: string;
  reason: string;
  e_stopped: boolean;
  command_age_ms: number | null;
  applied: Velocity;
}

/** An utterance heard while words were listened for, also where it was none of them. */
export interface HeardWords {
  /** When the utterance began: seconds of the robot's clock. */
  stamp: number;
  /** The word or phrase that was said; empty where that is unsure. */
  text: string;
  /** Whether to ask again: nothing may be done upon it. */
  unsure: boolean;
  /** Of `likeliest`, 0 to 1. */
  confidence: number;
  /** Which of the words is the likeliest, also where it is unsure; empty: none. */
  likeliest: string;
  /** Where it came from: a unit vector in `base_link`, from the array's middle. */
  direction: [number, number, number];
  /** What was listened for. */
  words: string[];
  /** Of the words, as `en`. */
  language: string;
}

/** What can be seen and done here. */
export interface Hello {
  protocol: 1;
  /** Id of this connection. */
  session: string;
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  robot: RobotFacts;
  scale: Scale;
  classes: DesireClassReport[];
  channels: Channels;
  /** What this connection may do. */
  role: "operator" | "spectator" | "supervisor";
  /** Whether an operator can drive here. */
  drive: boolean;
  /** Whether an operator can turn a head here. */
  head: boolean;
  audio: AudioFacts;
  /** Whether the camera's pictures come as VP9 to pages that say they decode it. */
  vp9: boolean;
  /** null: not a recording. */
  playback: PlaybackReport | null;
}

/**
 * The intention at work: what was selected, what follows from it, and why. Published when it is put in force, and again
 * once its reasons are complete.
 */
export interface IntentionReport {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  strategies: SelectedStrategy[];
  /** Classes whose strongest desire is fulfilled. */
  fulfilled: string[];
  /** Ω, what the selection is worth (thesis, equation 4.9). */
  omega: number;
  /** No selection can be worth more; equal to `omega` when proven, null where none is known. */
  bound: number | null;
  use: Record<string, ResourceUse>;
  /** φ of every filter that attention controls. */
  filters: Record<string, number | null>;
  /** Whether no better selection exists. */
  proven: boolean;
  solve_ms: number;
  /** Security desires that could not be kept. */
  relaxed: string[];
  /** By desired class. */
  reasons: Record<string, Reason>;
  /** What each module was handed. */
  parameters: Record<string, Record<string, unknown>>;
  /** Id of the strongest desire of each class that it answers. */
  desires: Record<string, string>;
  /** By class, what that desire asked for; empty in recordings of older programs. */
  asked: Record<string, Asked>;
  /** Strategies that were selected before; of equals, they stay. */
  previous: string[];
  /** Strategies that cost or produce otherwise than in the table that the program began with. */
  changed: ChangedStrategy[];
  /** What Ω is made of. */
  weights: OmegaWeights;
}

/** Where a recording goes on. */
export interface Jump {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
}

/** A map that is kept. */
export interface KeptMap {
  name: string;
  in_use: boolean;
  /** Unix time (s). */
  saved: number;
  /** Width and height of its picture. */
  size_m: [number, number];
  /** Of one cell, and of one pixel. */
  resolution_m: number;
  /** How much floor and wall of it is known. */
  known_m2: number;
  /** Whether it can go on growing when it is loaded. */
  extendable: boolean;
  /** How many it has. */
  zones: number;
  /** Why it cannot be used, in words. */
  problem: string | null;
}

/** What was found, each in its `frame`. */
export interface LandmarkList {
  landmarks: LandmarkReport[];
}

/** A QR code found: where its centre is in `frame` (m). */
export interface LandmarkReport {
  text: string;
  x: number;
  y: number;
  z: number;
  /** Standard deviation along each axis. */
  sigma_m: number;
  sightings: number;
  /** Seconds of the robot's clock (Unix epoch). */
  first_seen: number;
  /** Seconds of the robot's clock (Unix epoch). */
  last_seen: number;
  /** Direction in `frame` (rad) of its outward normal; null: unknown. */
  heading: number | null;
  /** Standard deviation of `heading` (rad). */
  heading_sigma: number | null;
  /** A number that it keeps on its map: one text may hang in several places. */
  id: number;
  /** `map` once the robot was localized on it, else `odom`. */
  frame: string;
}

/** A lane before now; of each bucket the rate's last value, its least and its greatest (null: there was none). */
export interface LaneBuckets {
  class: string;
  /** The last of each bucket. */
  rate: (number | null)[];
  /** Empty where every sample is a bucket. */
  low: (number | null)[];
  /** Empty where every sample is a bucket. */
  high: (number | null)[];
  /** Oldest first; of more than two in a bucket the most closed and the last. The first holds from the start. */
  changes: LaneChange[];
}

/** What a lane was, from ``stamp`` until the next change. */
export interface LaneChange {
  /** Robot's clock (s). */
  stamp: number;
  intensity: number | null;
  utility: number | null;
  /** φ: one message in φ passes; null: none passes. */
  divisor: number | null;
  /** By filter, `Module.port`. */
  divisors: Record<string, number | null>;
  state: "degraded" | "fulfilled" | "inhibited" | "needed" | "undesired" | "unfulfilled";
  text: string;
}

/** A lane before now. */
export interface LanePast {
  class: string;
  /** One for each stamp. */
  rate: (number | null)[];
  spells: LaneSpell[];
}

/** A desire class: how much it is desired, what attention gives it, and why. */
export interface LaneRow {
  class: string;
  /** Of its strongest desire; null: there is none. */
  intensity: number | null;
  /** Desired by that; null: there is none. */
  utility: number | null;
  /** Messages let through over messages offered, in the last second; 0 when closed, null: none was offered. */
  rate: number | null;
  /** φ: one message in φ passes; null: none passes. */
  divisor: number | null;
  /** By filter, `Module.port`, of its strategies at work. */
  divisors: Record<string, number | null>;
  state: "degraded" | "fulfilled" | "inhibited" | "needed" | "undesired" | "unfulfilled";
  text: string;
}

/** What a lane was, from one sample until the next spell's. */
export interface LaneSpell {
  /** Number of the sample. */
  at: number;
  intensity: number | null;
  utility: number | null;
  /** φ: one message in φ passes; null: none passes. */
  divisor: number | null;
  /** By filter, `Module.port`. */
  divisors: Record<string, number | null>;
  state: "degraded" | "fulfilled" | "inhibited" | "needed" | "undesired" | "unfulfilled";
  text: string;
}

/** 20 times a second: one row for each desire class, in a fixed order. */
export interface Lanes {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  rows: LaneRow[];
}

/** Once, before the first `lanes`, and after a `jump`: what they were. */
export interface LanesHistory {
  stamps: number[];
  rows: LanePast[];
}

/** What the lanes were in a stretch of time. Stamps are of the robot's clock (s). */
export interface LanesPast {
  /** Stamp of the oldest sample that is kept; null: there is none. */
  oldest: number | null;
  /** Width of a bucket; 0: every sample is one. */
  bucket_s: number;
  /** Of the first sample of each bucket. */
  stamps: number[];
  /** Of its last. */
  ends: number[];
  rows: LaneBuckets[];
}

/** How every stream between the program and its pages is delayed and bounded, for tests; not by the real network. */
export interface LinkReport {
  /** Whether it is at all. */
  shaped: boolean;
  /** Added to a round trip, half of it each way. */
  delay_ms: number;
  /** The delay varies by as much up and down. */
  jitter_ms: number;
  /** Packets that are lost and sent again. */
  loss_percent: number;
  /** Mbit/s each way; null: not bounded. */
  rate_mbit: number | null;
  /** The same in words; empty where nothing is shaped. */
  text: string;
}

/** What the modules take of the computer, once a second. */
export interface LoadReport {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** The time that it was measured over. */
  window_s: number;
  /** Per cent of one core. */
  process_cpu: number;
  /** Per cent that attention may give; null: no limit. */
  budget: number | null;
  modules: ModuleReport[];
  /** What attention makes of it; null: its loop is not closed. */
  loop: LoopReport | null;
}

/** Where the robot is on the map (m and rad). */
export interface LocalizationReport {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  state: "lost" | "mapping" | "searching" | "tracking";
  /** Name of the map in use; empty while it has none. */
  map: string;
  x: number;
  y: number;
  theta: number;
  /** Standard deviations of x, y (m) and theta (rad). */
  sigma: [number, number, number];
  /** Pose of `odom` on the map. */
  X_MO: PoseReport;
  /** Share of the scan that fits the map, 0 to 1. */
  overlap: number;
}

/** Attention's closed loop: costs follow what is measured, the budget of the CPU the pressure on the computer. */
export interface LoopReport {
  /** As it was set, in per cent of one core. */
  budget: number;
  /** What pressure leaves of it, at most 1. */
  share: number;
  /** CPU of all modules at work for strategies, measured over the last second. */
  used: number;
  /** Share of the time they wanted in which the program's threads had no core. */
  waiting: number | null;
  /** Idle time of the program's cores, in per cent of one core. */
  room: number | null;
  /** Share of the time in which some task of the computer had no core (PSI). */
  stalled: number | null;
  /** Tasks that could run, over those cores. */
  runnable: number | null;
  /** How late the event loop was on average. */
  late_ms: number | null;
  /** Those at work that take CPU. */
  strategies: StrategyLoad[];
  /** Why costs or share changed last, in words; empty: they never did. */
  why: string;
}

/**
 * A frame of sound much louder than those before it: ``ratio`` of its energy to their moving mean (thesis 4.2).
 * ``level_db`` is the frame's level, dB of full scale. ``stamp`` is the time of the frame's first sample.
 */
export interface LoudNoise {
  stamp: number;
  ratio: number;
  level_db: number;
}

/** Every map that is kept, by name, and the one in use. */
export interface MapList {
  folder: string;
  current: CurrentMap;
  maps: KeptMap[];
}

/** A picture or a video. */
export interface Media {
  /** Its path in the folder of tours, as media/arm.jpg. */
  file: string;
  /** What it shows, for those who do not see it. */
  alt: Record<string, string>;
}

/** What was perceived and done at one time. */
export interface MemoryEvent {
  id: number;
  items: MemoryItem[];
}

/** Something that belongs to an event. */
export interface MemoryItem {
  channel: "desire" | "emotion" | "object" | "person" | "place";
  /**
   * Which: `someone`, or `person 3` by the number of this run of the program; `code lab` by the place in front of which
   * it hangs, else by a number; `word hello`; a place's id on its map; the class of a desire.
   */
  item: string;
  /** How firmly it belongs to it, over 0 and at most 1. */
  weight: number;
}

/** What happens now, as memory sees it, and the episodes it has; published with each change. */
export interface MemoryState {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** Whether anything is remembered. */
  on: boolean;
  /** Why nothing is written to the disk, in words; empty: nothing is wrong. */
  problem: string;
  /** The last events of the episode under way, at most 12, in order. */
  under_way: MemoryEvent[];
  /** The episode that this is like; null: none. */
  recognized: number | null;
  /** How much it is like it, 0 to 1. */
  match: number;
  /** What comes next by that, the next first, at most 5. */
  anticipated: AnticipatedEvent[];
  raised: RaisedDesire[];
  /** At most 20, those that happened last first. */
  episodes: EpisodeSummary[];
  episode_count: number;
  event_count: number;
}

/** The intensity of a desire is raised by an emotion. */
export interface Modulation {
  /** So much is added to its intensity, over 0; the sum is at most 8. */
  by: number;
  /** The emotion that its neglect has fed. */
  emotion: "anger" | "fear" | "joy" | "sadness";
}

/** A module's input and its counters since the start. */
export interface ModuleInput {
  /** φ: one message in φ passes; null: none passes. */
  divisor: number | null;
  /** Messages offered, or left out by the source on behalf of the filters. */
  received: number;
  /** ... let through by the filter. */
  passed: number;
  /** ... stopped by the filter, or left out, as wanted. */
  decimated: number;
  /** ... pushed out of a full inbox. */
  dropped: number;
  /** Age of the last message when it was taken. */
  age_ms: number | null;
  name: string;
  channel: string;
}

/** A module's output. */
export interface ModuleOutput {
  name: string;
  /** null: nothing is connected. */
  channel: string | null;
  /** φ: one message in φ passes; null: none passes. */
  divisor: number | null;
  offered: number;
}

/** One module, its load and its counters. */
export interface ModuleReport {
  name: string;
  title: string;
  state: "failed" | "hung" | "running" | "starting" | "stopped";
  /** Per cent of one core, over the last second. */
  cpu: number;
  /** What it is expected to stay under. */
  cpu_budget: number | null;
  /** CPU time for each message taken (µs). */
  message_cpu_us: number | null;
  restarts: number;
  problem: string | null;
  inputs: ModuleInput[];
  outputs: ModuleOutput[];
  /** Its layer in the architecture, by the package that it comes from. */
  role: "actuation" | "behaviors" | "motivations" | "other" | "perception" | "sensors";
}

/** State of the behavior that drives to a goal; as `navigation` on the live stream. */
export interface NavigationModel {
  stamp: number;
  /** Empty before the first report. */
  behavior: string;
  state: "idle" | "planning" | "following" | "recovering" | "waiting" | "arrived" | "unreachable";
  /** In words, and what would help. */
  reason: string;
  goal: GoalPoseModel | null;
  /** The nearest reachable place, which it drives to. */
  target: GoalPoseModel | null;
  remaining_m: number | null;
  recoveries: number;
  /** Id of the strongest desire to go somewhere. */
  desire: string | null;
  /** Points on the map (m), at most 200. */
  path: [number, number][];
  /** The goal given up last, until there is another or DELETE /goal; null: none. */
  given_up: GivenUpModel | null;
}

/** Something for this viewer, in words to show. */
export interface Notice {
  level: "error" | "info" | "warning";
  text: string;
}

/** Pose in `odom` (m, rad) and measured velocity (m/s, rad/s). */
export interface OdometryReport {
  x: number;
  y: number;
  theta: number;
  linear_mps: number;
  angular_radps: number;
  lateral_mps: number;
}

/**
 * What Ω is made of: intensity·i of what is fulfilled, utility·v of what serves it, spare for each unit left of a
 * resource.
 */
export interface OmegaWeights {
  /** Of the intensities of fulfilled desires; 1 in the thesis. */
  intensity: number;
  /** Of produced utilities; 1 in the thesis. */
  utility: number;
  /** Of each unit of `spare_of` that is left; 0 in the thesis. */
  spare: number;
  /** The resource. */
  spare_of: string;
}

/** What the robot asks its operator; without an answer it does what it says. */
export interface OperatorQuestion {
  /** The question. */
  text: string;
  /** Buttons that answer it. */
  answers:
    | ("agree"
    | "decline"
    | "end"
    | "next"
    | "pause"
    | "repeat"
    | "resume"
    | "retry"
    | "skip"
    | "start"
    | "undo_skip")[];
  /** What it does without an answer, in words. */
  default: string;
  /** When it does that (robot's clock, s). */
  until: number;
}

/** How the robot leads. */
export interface Pace {
  /** Share of the robot's greatest speed. */
  speed: number;
  /** It slows down while visitors are farther behind (m). */
  slow_m: number;
  /** It waits while visitors are farther behind (m). */
  wait_m: number;
  /** So long it waits; then it goes on with those who are there, or ends. */
  give_up_s: number;
  /** It turns to look for visitors every so many metres: sensors see only ahead. */
  look_back_m: number;
}

/**
 * A person, by all that is perceived of them. ``track`` is the number of one uninterrupted perception and ``person``
 * the identity, which is kept over interruptions: None while ``tentative`` (not yet believed to be a person) and while
 * ``unsure`` (a person, but one of several known ones, or a new one). A person ``lost`` was not perceived for a second,
 * and is predicted. No number is used again. ``p_OP`` (m, in ``odom``) is the middle of the face, its height that of
 * people in general where none was seen; ``v_O`` (m/s) the velocity over ground, ``covariance`` (2, 2) float64 m² of
 * the place over ground. ``face`` and ``voice`` are the tracks of what is bound to the person now, None without;
 * ``legs`` whether the laser sees them. ``speaking``: the voice sounds now. ``last_seen`` (s, robot's clock) by a
 * camera or the laser.
 */
export interface Person {
  track: number;
  person: number | null;
  state: "confirmed" | "lost" | "tentative" | "unsure";
  p_OP: [number, number, number];
  v_O: [number, number];
  covariance: [number, number][];
  face: number | null;
  voice: number | null;
  legs: boolean;
  speaking: boolean;
  last_seen: number;
}

/** All persons at ``stamp``, in the order of their tracks. */
export interface Persons {
  stamp: number;
  persons: Person[];
}

/** Every place of the map in use, in the order of their making. */
export interface PlaceList {
  places: PlaceReport[];
}

/** A named pose on the map. */
export interface PlaceReport {
  /** Never changes. */
  id: string;
  /** For people; no two places share one. */
  name: string;
  /** On the map (m). */
  x: number;
  /** On the map (m). */
  y: number;
  /** On the map (rad). */
  heading: number;
  /** `hand`: by its coordinates. `here`: where the robot stood. `poster`: in front of one, which it follows. */
  source: "hand" | "here" | "poster";
  /** Text of that poster; empty: none. */
  poster: string;
  /** Number of that poster's landmark on this map; 0: none. */
  landmark: number;
  /** Why the robot cannot stand there, or what is doubtful, in words; empty: nothing. */
  problem: string;
  /** Its version, for `If-Match`. A pose that follows its poster is no new version. */
  etag: string;
}

/**
 * A QR code in one image of ``camera``: its ``corners`` (4, 2) float64 px, in the order of ``QRCode``, in the image of
 * ``image`` (width, height) px.
 */
export interface PlacedCode {
  text: string;
  camera: string;
  stamp: number;
  corners: [number, number][];
  image: [number, number];
}

/**
 * A face in one image of ``camera``, placed with the robot's pose at ``stamp``. ``azimuth`` (left positive) and
 * ``elevation`` (rad) in the axes of B, from the camera as it was then; ``panorama`` is both, from where the newest
 * panorama was taken (None: there is none). ``range_m`` from the camera, with standard deviation ``range_sigma_m``.
 * ``x``, ``y``, ``z`` (m) is its place in O and ``towards_O`` the heading (rad in O) in which it has the robot, all
 * None before the pose at ``stamp`` is known. ``box`` is left, top, width, height (px) in the image of ``image``
 * (width, height) px.
 */
export interface PlacedFace {
  track: number;
  camera: string;
  stamp: number;
  azimuth: number;
  elevation: number;
  panorama: [number, number] | null;
  range_m: number | null;
  range_sigma_m: number | null;
  x: number | null;
  y: number | null;
  z: number | null;
  towards_O: number | null;
  score: number;
  box: [number, number, number, number];
  image: [number, number];
}

/**
 * What the robot sees and hears at ``stamp``; published when it changes. ``faces`` by track and camera, ``sounds`` by
 * track, ``noises`` of the last 2 s, ``codes`` by text and camera.
 */
export interface PlacedPercepts {
  stamp: number;
  faces: PlacedFace[];
  sounds: PlacedSound[];
  noises: LoudNoise[];
  codes: PlacedCode[];
}

/**
 * A tracked sound, placed with the robot's pose at ``stamp``: angles and place as in ``PlacedFace``. Angles and
 * ``range_m`` are from the microphones' middle, which is at ``p_OA`` (m in O); ``v_O`` is the direction as a unit
 * vector in the axes of O. Place and range are None where the distance is not known, all of O before the pose is.
 * ``active``: it sounds now, else it did last at ``last_active``; ``speech`` is None while nothing has judged it.
 */
export interface PlacedSound {
  track: number;
  stamp: number;
  azimuth: number;
  elevation: number;
  panorama: [number, number] | null;
  range_m: number | null;
  range_sigma_m: number | null;
  x: number | null;
  y: number | null;
  z: number | null;
  p_OA: [number, number, number] | null;
  v_O: [number, number, number] | null;
  power: number;
  level_db: number;
  active: boolean;
  last_active: number;
  speech: number | null;
}

/** State of the playback; stamps are the recording's. */
export interface PlaybackReport {
  /** Name of the recording's file. */
  file: string;
  /** Seconds of the robot's clock (Unix epoch). */
  begin: number;
  /** Seconds of the robot's clock (Unix epoch). */
  end: number;
  /** Seconds of the robot's clock (Unix epoch). */
  position: number;
  /** Seconds of the recording in a real second; null: as fast as possible, nothing dropped. */
  speed: number | null;
  /** Whether time goes on, or will after the seek under way. */
  playing: boolean;
  phase: "ended" | "paused" | "playing" | "seeking";
  /** Why it cannot go on: the part of the recording that cannot be read. */
  problem: string | null;
}

/** The answer to `ping`. */
export interface Pong {
  /** As it was sent. */
  t: number | null;
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
}

/** A pose: m and rad. */
export interface PoseReport {
  x: number;
  y: number;
  theta: number;
}

/** A stop's own PresentRule: what is left out is the tour's. */
export interface PresentException {
  retry: number | null;
  then: "continue" | "skip" | "end" | null;
}

/** What to do where a step fails: no voice, an arm that cannot point there. */
export interface PresentRule {
  /** So often the step is tried again. */
  retry: number;
  /** Go on with the next step, leave the rest of the stop out, or end. */
  then: "continue" | "skip" | "end";
}

/** A question that visitors may ask at a stop, and its answer. */
export interface Question {
  id: string;
  /** As visitors read it, to press it. */
  question: Record<string, string>;
  /** Words by which it is recognized when it is asked aloud, by language. */
  words: Record<string, string[]>;
  /** The answer: a step that says or shows something. */
  answer: Step;
}

/** A desire of memory's. */
export interface RaisedDesire {
  /** Of the desire. */
  id: string;
  class: string;
  intensity: number;
  /** The episode that is the reason. */
  episode: number;
  /** In words. */
  why: string;
}

/** A desire whose intensity is raised. */
export interface RaisedIntensity {
  /** Of the desire. */
  id: string;
  class: string;
  by: number;
  emotion: "anger" | "fear" | "joy" | "sadness";
}

/** A stop's own ReachRule: what is left out is the tour's. */
export interface ReachException {
  retry: number | null;
  ask_s: number | null;
  then: "skip" | "present_from_here" | "end" | null;
}

/** What to do where a stop cannot be reached. */
export interface ReachRule {
  /** So often it tries again. */
  retry: number;
  /** So long it then asks the operator; 0: it does not ask. */
  ask_s: number;
  /** Without an answer: leave the stop out, present it from where the robot is, or end. */
  then: "skip" | "present_from_here" | "end";
}

/** Why a desired class gets what it gets. */
export interface Reason {
  state: "degraded" | "fulfilled" | "inhibited" | "unfulfilled";
  /** The utility it gets. */
  utility: number;
  /** The utility desired. */
  wanted: number;
  /** The most that any selection could give it. */
  best: number;
  /** The reason in words. */
  text: string;
  alternatives: Alternative[];
  /** Whether the search for alternatives was complete. */
  searched: boolean;
  /** What lessens the utility that its strategies produce now; empty: nothing. */
  remark: string;
}

/** State of the Recorder. */
export interface RecorderReport {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** `ring`: the last minutes are kept. `stopped`: by itself, though still desired; see `reason`. */
  state: "idle" | "recording" | "ring" | "stopped";
  /** The recording's; empty while idle. */
  name: string;
  /** When it began (robot's clock, s). */
  began: number | null;
  duration_s: number;
  /** On disk so far. */
  bytes: number;
  messages: number;
  /** Messages that could not be queued for the disk. */
  dropped: number;
  /** What waits for the disk now. */
  queued_bytes: number;
  /** Of the ring; 0: everything goes into one file. */
  keep_minutes: number;
  /** Whether there is a desire for a recording. */
  desired: boolean;
  /** Why it does not record though it is desired, in words; empty when all is well. */
  reason: string;
  /** Whether it runs and attention has a strategy for it. */
  available: boolean;
}

/** Every recording, the newest first, and what the Recorder does. */
export interface RecordingList {
  folder: string;
  /** Room left on its disk. */
  free_bytes: number;
  /** null: this program has no Recorder. */
  recorder: RecorderReport | null;
  /** The replay that this console started, while it runs. */
  replay: ReplayReport | null;
  recordings: RecordingReport[];
}

/** One recording. */
export interface RecordingReport {
  name: string;
  bytes: number;
  /** From its first message to its last; null where it is not known. */
  duration_s: number | null;
  /** Its first message (robot's clock, s); null where it is not known. */
  began: number | null;
  /** `unfinished`: it was never closed; `hbba log repair` makes it readable. */
  state: "complete" | "recording" | "unfinished";
  /** The robot's name; empty where the file does not say. */
  robot: string;
}

/** A tour as it was rehearsed. */
export interface Rehearsal {
  tour: string;
  language: string;
  /** Why it ended, in words. */
  outcome: string;
  /** Since the rehearsal's begin, s. */
  duration_s: number;
  driven_m: number;
  /** Ids of those that were presented, in order. */
  stops: string[];
  states: RehearsedState[];
  subtitles: Subtitle[];
  path: RehearsedPose[];
  problems: RehearsalProblem[];
}

/** What would go wrong. An ``error`` keeps the tour from being led as it is written; a ``warning`` does not. */
export interface RehearsalProblem {
  severity: "error" | "warning";
  /** Id of the stop; empty: none. */
  stop: string;
  /** One sentence. */
  message: string;
  at_s: number | null;
}

/** The rehearsal that is under way, or the last. */
export interface RehearsalReport {
  state: "done" | "failed" | "none" | "running";
  /** Id of the tour; empty: there was none. */
  tour: string;
  /** Of the visitors. */
  language: string;
  /** Unix time, s. */
  began: number | null;
  /** How much of the tour was played (s). */
  seconds: number;
  /** Id of the stop that it is at; empty: none. */
  stop: string;
  /** Why it failed, in words; empty: it did not. */
  problem: string;
  /** Whether nothing keeps the tour from being led; null: not known. */
  can_be_led: boolean | null;
  /** What was found; null: nothing yet. */
  result: Rehearsal | null;
}

/** Where the robot was, on the map (m, rad), and how far the farthest visitor was from it (m; null: nobody). */
export interface RehearsedPose {
  /** Since the rehearsal's begin, s. */
  at_s: number;
  x: number;
  y: number;
  heading: number;
  farthest_m: number | null;
}

/** A state of the guide, as it began. */
export interface RehearsedState {
  /** Since the rehearsal's begin, s. */
  at_s: number;
  state: string;
  /** Id of the stop; empty: none. */
  stop: string;
  /** In words; may be empty. */
  reason: string;
}

/** A replay that runs. */
export interface ReplayReport {
  /** The recording replayed. */
  name: string;
  /** Its console's address, with the token behind `#` where there is one. */
  url: string;
}

/** Every resource. */
export interface ResourceList {
  resources: ResourceReport[];
}

/** What strategies share. */
export interface ResourceReport {
  name: string;
  /** How much of it attention may give now. */
  capacity: number;
  /** Its capacity in configuration. */
  declared: number;
  /** What the intention at work uses of it. */
  used: number;
  /** As it was set last; `capacity` is less while others press on the computer. */
  budget: number;
  unit: string;
  description: string;
}

/** What is used of a resource. */
export interface ResourceUse {
  used: number;
  capacity: number;
  unit: string;
}

/** The body and its limits. */
export interface RobotFacts {
  name: string;
  /** What this robot is called among others (`console.name`); its `name` without one. */
  called: string;
  simulated: boolean;
  /** Whether it is the body of a replay: it can neither be driven nor stopped. */
  replayed: boolean;
  limits: BaseLimits;
  /** Corners of its outline (m, in base_link), counter-clockwise; empty for one that does not move. */
  footprint: [number, number][];
  cautions: Caution[];
}

/** A way from one point of a route to the next. */
export interface RouteLegReport {
  /** `way`: it leads there. `near`: to the nearest place that can be reached. `none`: it cannot be driven. */
  state: "near" | "none" | "way";
  /** Why it does not lead there, or what is special about it, in words; empty: nothing. */
  reason: string;
  length_m: number;
  /** About how long it takes if nothing is in the way, with turns on the spot. */
  duration_s: number;
  /** Its corners x, y on the map (m), at most 200. */
  path: [number, number][];
}

/** A route, leg by leg. */
export interface RouteReport {
  /** The map in use; empty: it has no name yet. */
  map: string;
  /** One less than points. */
  legs: RouteLegReport[];
  /** Of all legs that can be driven. */
  length_m: number;
  /** Of all legs that can be driven. */
  duration_s: number;
}

/** A rule by which something is desired (docs/rules.md), and what it did. */
export interface RuleReport {
  name: string;
  /** What it is for, in words; may be empty. */
  about: string;
  /** When it applies, in words. */
  words: string;
  /** The file that it is in. */
  file: string;
  /** Its line there, from 1. */
  line: number;
  enabled: boolean;
  /** Of a rule with `while`: whether it applies now; null of others. */
  holds: boolean | null;
  /** How often it applied. */
  fired: number;
  /** When it applied last (robot's clock, s); null: never. */
  last_fired: number | null;
  /** What made it apply then, in words. */
  last_event: string;
  /** Ids of the desires that there are by it. */
  desires: string[];
  /** Why something it should have done was not done, when it applied last. */
  problem: string;
}

/** The rules in force, in their order; published when one applies, and when their files change. */
export interface RulesReport {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  rules: RuleReport[];
  /** The files that they are read from. */
  files: string[];
  /** Why the files, as they are now, are not in force: file, line and mistake; empty: they are. */
  problem: string;
}

/** What a run of a tour was. */
export interface RunReport {
  /** Its id. */
  run: string;
  /** Id of the tour. */
  tour: string;
  /** Of the tour, by language. */
  title: Record<string, string>;
  /** That the robot spoke. */
  language: string;
  /** Unix time, s. */
  began: number;
  /** Unix time, s; null: it is under way. */
  ended: number | null;
  /** Why it ended, in words; empty: it has not. */
  outcome: string;
  /** Whether visitors came along. */
  agreed: boolean;
  /** How many were seen when it began. */
  people_begin: number;
  /** The most that were seen at once. */
  people_most: number;
  /** How many were seen at the farewell. */
  people_end: number;
  /** The way that was driven (m). */
  driven_m: number;
  /** How often it waited for visitors, or looked back for them. */
  waits: number;
  /** How long in all. */
  waited_s: number;
  pauses: number;
  paused_s: number;
  /** In the order of the way; one that was gone to twice is there twice. */
  stops: StopReport[];
  failures: TourFailure[];
}

/** Reports on runs of tours, the newest first. */
export interface RunReportList {
  reports: RunReport[];
}

/**
 * How salient all directions around the head are at ``stamp``. ``cells`` (rows, columns) uint8: 255 is the saliency
 * ``full``, or more. Rows go from the top down, ``step`` rad each, with level in the middle; columns from azimuth +π to
 * -π (left positive) in the axes of B.
 */
export interface SaliencyMap {
  stamp: number;
  step: number;
  full: number;
  cells: number[][];
}

/**
 * A direction that stands out: ``azimuth`` (left positive) and ``elevation`` (rad) from the head, in B's axes.
 * ``saliency`` is the sum of the other members, what each feature gives to it, weighted with its gain.
 */
export interface SalientRegion {
  azimuth: number;
  elevation: number;
  saliency: number;
  motion: number;
  color: number;
  contrast: number;
  faces: number;
  sounds: number;
}

/**
 * The most salient regions at ``stamp``, the most salient first, three at most; directions are from ``p_BH``, the
 * middle of the sphere around the head (m in B).
 */
export interface SalientRegions {
  stamp: number;
  p_BH: [number, number, number];
  regions: SalientRegion[];
}

/** The recording made of the ring. */
export interface Saved {
  name: string;
}

/** The ends of the scales of desires. */
export interface Scale {
  intensity: number;
  utility: number;
}

/** Where a page takes the 3D view for a frame from. */
export interface SceneAddress {
  /** On its own port; null: from the console's, at `viser/`. */
  url: string | null;
}

/** What a point of a 3D view shows. */
export interface ScenePoint {
  /** `poster`: one that was found; `wall`: of the map; `seen`: by the depth camera; `nothing`: the sky. */
  kind: "floor" | "nothing" | "poster" | "seen" | "wall";
  /** `odom` while it is not known where the robot is on the map. */
  frame: "map" | "odom";
  /** In m, as `y` and `z`: of a poster its middle; null: nothing is there. */
  x: number | null;
  y: number | null;
  /** Above the floor. */
  z: number | null;
  /** What the poster says. */
  text: string | null;
  /** The poster's `id`, which it keeps on its map. */
  landmark: number | null;
}

/** A strategy at work. */
export interface SelectedStrategy {
  name: string;
  class: string;
  utility: number;
  filters: Record<string, number | null>;
  costs: Record<string, number>;
}

/** The emotion that face and voice show, one at a time. */
export interface ShownEmotion {
  emotion: "anger" | "fear" | "joy" | "sadness";
  /** How strongly it shows: over 0, to 1. */
  strength: number;
  /**
   * Id of the desire Express that is stated for the face; empty: none, since another expression is desired, or the
   * robot has no face.
   */
  desire: string;
}

/** A picture or a video that visitors are shown. */
export interface ShownMedia {
  /** Its path in the folder of tours. */
  file: string;
  /** What it shows, by language. */
  alt: Record<string, string>;
  /** Whether it is a video. */
  video: boolean;
}

/** Times, of the robot's place, at which the tour begins by itself. */
export interface Slot {
  days: ("mon" | "tue" | "wed" | "thu" | "fri" | "sat" | "sun")[];
  times: string[];
}

/**
 * The author of a desire: a motivation of the robot, an operator at the console or a REST client, by name; of a
 * motivation that goes by rules, the rule, its event and the time.
 */
export interface Source {
  kind: "motivation" | "operator" | "rest";
  name: string;
  /** The rule that it came by; empty: by none. */
  rule: string;
  /** What made the rule apply, in words; empty without a rule. */
  event: string;
  /** When the rule applied (robot's clock, s); null without a rule. */
  applied: number | null;
  /**
   * Of a motivation, its kind: `instinctive` (what the robot itself needs), `rational` (its task) or `emotional`
   * (conflicts, feelings); null: it is no motivation, or says none.
   */
  motive: "emotional" | "instinctive" | "rational" | null;
}

/** Freshness of a channel: its measured and its expected rate. */
export interface SourceState {
  channel: string;
  state: "closed" | "live" | "stale" | "waiting";
  age_ms: number | null;
  rate_hz: number | null;
  expected_hz: number | null;
}

/** The operator who speaks through the robot. */
export interface Speaker {
  operator: string;
  /** Whether it is this page's operator. */
  mine: boolean;
}

/** What the robot says now, for subtitles and for its mouth; published with each change. */
export interface Speech {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  state: "silent" | "speaking";
  /** The sentence that is said, or was said last. */
  text: string;
  /** The word of it that is said: its first character, from 0. */
  word_begin: number;
  /** The character after its last; equal to the first before the first word. */
  word_end: number;
  /** The mouth: `closed`, `teeth`, `narrow`, `spread`, `mid`, `open`, `round` or `pursed`. */
  viseme: string;
  /** Of the text, as `en`. */
  language: string;
  /** Id of the desire that is being fulfilled; empty while silent. */
  desire: string;
  /** Number of other texts that wait. */
  waiting: number;
}

/** How the robot places itself at a stop. */
export interface Stand {
  /** Towards visitors, the poster (where the map knows it), or as the place says. */
  face: "visitors" | "poster" | "place";
  /** So near the place is there (m). */
  tolerance_m: number;
  /** So well turned is turned (rad). */
  tolerance_rad: number;
}

/** Guard, pose, driver, freshness of every source. */
export interface Status {
  /** Grows. */
  seq: number;
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  guard: Guard;
  world_rate: number;
  odometry: OdometryReport | null;
  driver: Driver | null;
  asker: Asker | null;
  speaker: Speaker | null;
  /** The behavior that drives. */
  exploited: string | null;
  /** Why the collision monitor slowed or stopped it, in words; empty: it did not. */
  limited: string;
  /** The actuator groups but for the base. */
  groups: GroupReport[];
  /** Why this viewer's driving waits, its commands coming too late; empty: it does not. */
  waits: string;
  sources: SourceState[];
  /** Why this viewer drives slower than its stick says; empty: it does not. */
  slowed: string;
  /** The share of the speeds of its stick that this viewer is given for it, 0 to 1. */
  share: number;
}

/** What goes on at once; the step is over when all of it is. A picture stays until the next, or the stop's end. */
export interface Step {
  /** What to say, by language. */
  say: Record<string, string> | null;
  /** Where to look: visitors, the stop's poster, or a point x, y, z on the map (m). */
  look: "visitors" | "poster" | [number, number, number] | null;
  /** Where an arm points: x, y, z on the map (m), z above the floor. */
  point: [number, number, number] | null;
  /** What visitors see on their page. */
  show: Media | null;
  /** A gesture of the body's. */
  gesture: Gesture | null;
  /** What the face expresses, as happy. */
  expression: string | null;
  /** How long, and for what, to wait. */
  wait: Wait | null;
}

/** A place where the robot presents something. */
export interface Stop {
  id: string;
  place: string;
  title: Record<string, string>;
  /** Text of the code that hangs there; HBBA:STOP/ and the id in capitals is read farthest. */
  poster: string | null;
  stand: Stand;
  /** Words by which visitors ask to be led there, by language. */
  words: Record<string, string[]>;
  /** Steps, one after another. */
  do: Step[];
  questions: Question[];
  on_failure: FailureExceptions;
  /** Whether it is passed over for now. */
  left_out: boolean;
}

/** What became of one stop. */
export interface StopReport {
  /** Its id. */
  stop: string;
  /** When the robot set out for it (Unix time, s). */
  began: number;
  /** When it was there (Unix time, s); null: never. */
  arrived: number | null;
  /** When it was presented, or left (Unix time, s); null: not yet. */
  ended: number | null;
  /** Whether all of it was presented. */
  presented: boolean;
  /** Whether people skipped it. */
  skipped: boolean;
  /** The most people that were seen there at once. */
  people: number;
  /** How often each question was asked, by its id. */
  questions: Record<string, number>;
}

/** Every strategy, in table order. */
export interface StrategyList {
  strategies: StrategyReport[];
}

/** CPU of a strategy at work, in per cent of one core. */
export interface StrategyLoad {
  name: string;
  class: string;
  /** As its file says, or as calibrated on this computer. */
  declared: number;
  /** Over the last second; null: it was not at work all that time. */
  measured: number | null;
  /** By all that was measured. */
  estimated: number;
  /** What attention reckons with. */
  used: number;
}

/** One way to serve a desire class. */
export interface StrategyReport {
  name: string;
  class: string;
  /** Produced utility v, over 0 and at most 8, as attention reckons now. */
  utility: number;
  /** Utility needed of other classes. */
  requires: Record<string, number>;
  /** φ by `Module.port`. */
  filters: Record<string, number | null>;
  /** What modules are handed while it is selected, by module. */
  parameters: Record<string, Record<string, unknown>>;
  /** What it uses of each resource, as attention reckons now. */
  costs: Record<string, number>;
  selected: boolean;
  /** File and line. */
  declared: string | null;
  /** As declared there, or calibrated on this computer. */
  declared_costs: Record<string, number>;
  /** As declared there: `utility` is less while a perception works badly. */
  declared_utility: number;
}

/** A sentence that was said. */
export interface Subtitle {
  /** Since the rehearsal's begin, s. */
  at_s: number;
  /** Since the rehearsal's begin, s. */
  until_s: number;
  text: string;
  language: string;
}

/** One event of the timeline; ``data`` is JSON as it is. */
export interface TimelineEvent {
  /** Grows by one from 1. */
  id: number;
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  kind:
    | "accomplishment"
    | "battery"
    | "capacity"
    | "desire"
    | "emotion"
    | "exploitation"
    | "filter"
    | "goal"
    | "guard"
    | "intention"
    | "memory"
    | "module"
    | "overload"
    | "percept"
    | "restart"
    | "rule"
    | "solver"
    | "stale"
    | "tour";
  /** What it is about: a desire class, a module, a filter. */
  subject: string;
  /** One sentence. */
  text: string;
  data: Record<string, unknown>;
}

/** A guided tour. */
export interface Tour {
  /** Of this file. */
  format: 1;
  id: string;
  title: Record<string, string>;
  /** Spoken on it; every text has the first of them. */
  languages: string[];
  /** The map that its places are on. */
  map: string;
  /** Where the robot goes afterwards; none: it stays. */
  home: string | null;
  begin: Begin;
  schedule: Slot[];
  battery: BatteryRule;
  pace: Pace;
  on_failure: FailureRules;
  greeting: Greeting;
  farewell: Farewell;
  commands: Commands;
  /** Texts of further codes that are obeyed when visitors show them while the tour waits at a stop. */
  accept: string[];
  stops: Stop[];
}

/** Something on a tour that failed. */
export interface TourFailure {
  /** Id of the stop. */
  stop: string;
  /** In words. */
  what: string;
}

/** Every tour, by id. */
export interface TourList {
  /** Of the user's tours, on the robot's computer. */
  folder: string;
  tours: TourSummary[];
}

/** A picture or a video that tours can show. */
export interface TourMedia {
  /** As a tour's `show` names it. */
  file: string;
  type: string;
  /** Whether it is a video. */
  video: boolean;
  /** In bytes. */
  size: number;
  /** Unix time, s. */
  changed: number;
  /** Whether it came with the program. */
  shipped: boolean;
  /** Ids of the tours that show it. */
  tours: string[];
}

/** All that tours can show, by name. */
export interface TourMediaList {
  media: TourMedia[];
  /** Pictures with more bytes are not taken. */
  largest_picture: number;
  /** Videos with more bytes are not taken. */
  largest_video: number;
}

/** A problem of a tour. */
export interface TourProblemReport {
  /** The value that it is about, as `stops.0.place`. */
  field: string;
  message: string;
  /** `mistake`: not kept; `error`: kept, and cannot run; `warning`: runs all the same. */
  severity: "error" | "mistake" | "warning";
}

/** How the tour that is under way goes, or waits for visitors; published with each change. */
export interface TourProgress {
  /** Seconds of the robot's clock (Unix epoch). */
  stamp: number;
  /** Id of the run; empty before the first. */
  run: string;
  /** Id of the tour; empty: none is under way, and none waits for visitors. */
  tour: string;
  /** Of the tour, by language. */
  title: Record<string, string>;
  /** That the robot speaks. */
  language: string;
  languages: string[];
  /** Whether visitors and the schedule begin it, again and again. */
  waits: boolean;
  state:
    | "answering"
    | "blocked"
    | "confirming"
    | "going_home"
    | "idle"
    | "inviting"
    | "leading"
    | "listening"
    | "lost"
    | "parting"
    | "paused"
    | "presenting"
    | "searching"
    | "turning"
    | "waiting";
  /** When the state began (robot's clock, s). */
  since: number;
  /** Why it is in this state, in words; may be empty. */
  reason: string;
  /** Id of the stop that it is at, or on the way to; empty: none. */
  stop: string;
  /** By language. */
  stop_title: Record<string, string>;
  /** Of the stop among those that are not left out, from 1; 0: none. */
  number: number;
  /** How many there are that are not left out. */
  stops: number;
  /** Of the stop, greeting or farewell, from 1; 0: none. */
  step: number;
  steps: number;
  /** What is said in this step, by language; none: nothing. */
  text: Record<string, string>;
  /** Which sentence of it, from 0. */
  sentence: number;
  /** What visitors are shown; null: nothing. */
  shown: ShownMedia | null;
  /** What the button `next` is called, by language; none: it is not waited for. */
  press: Record<string, string>;
  /** That visitors may ask now. */
  questions: TourQuestion[];
  /** That do something now. */
  buttons:
    | ("agree"
    | "decline"
    | "end"
    | "next"
    | "pause"
    | "repeat"
    | "resume"
    | "retry"
    | "skip"
    | "start"
    | "undo_skip")[];
  /** That the operator is asked; null: none. */
  question: OperatorQuestion | null;
  /** How many are seen. */
  people: number;
  /** The distance of the farthest of them (m); null: none is seen. */
  farthest_m: number | null;
  /** Ids of the stops that were presented. */
  presented: string[];
  /** Ids of the stops that were skipped. */
  skipped: string[];
  failures: TourFailure[];
}

/** A question that visitors may ask at a stop. */
export interface TourQuestion {
  id: string;
  /** By language. */
  question: Record<string, string>;
}

/** A tour, and what is to be said of it. */
export interface TourReport {
  /** As `GET /tour-schema` describes it, every member there. */
  tour: Record<string, unknown>;
  /** Whether it came with the program and was not changed. */
  shipped: boolean;
  can_undo: boolean;
  can_redo: boolean;
  /** The worst first. */
  problems: TourProblemReport[];
}

/** The tour that is under way. */
export interface TourRunReport {
  /** How it goes now. */
  progress: TourProgress;
  /** What the run has been so far, or the last one was; null: none. */
  report: RunReport | null;
}

/** A tour in the list of all. */
export interface TourSummary {
  id: string;
  /** By language. */
  title: Record<string, string>;
  languages: string[];
  map: string;
  /** How many are not left out. */
  stops: number;
  /** Whether it came with the program and was not changed. */
  shipped: boolean;
  etag: string;
  /** Problems for which it cannot run. */
  errors: number;
  warnings: number;
  /** Why its file cannot be read, in words; all else is empty then. */
  problem: string | null;
}

/** Forward m/s, turn rad/s and sideways m/s (left positive). */
export interface Velocity {
  linear_mps: number;
  angular_radps: number;
  lateral_mps: number;
}

/** The way in for phones of visitors. */
export interface VisitorLink {
  /** Of the page for visitors, with the key of this run; empty: there is no way in now. */
  url: string;
  /** The same as a QR code: its rows from the top, `1` for each black module. */
  code: string[];
  /** Why phones do not get in by it, in words; empty: they do. */
  problem: string;
}

/** How the tour goes, for visitors. */
export interface VisitorView {
  /** Whether one is led, or waits for visitors. */
  tour: boolean;
  /** By language. */
  title: Record<string, string>;
  /** That the robot speaks. */
  language: string;
  languages: string[];
  state:
    | "answering"
    | "blocked"
    | "confirming"
    | "going_home"
    | "idle"
    | "inviting"
    | "leading"
    | "listening"
    | "lost"
    | "parting"
    | "paused"
    | "presenting"
    | "searching"
    | "turning"
    | "waiting";
  /** By language. */
  stop_title: Record<string, string>;
  /** Of the stop, from 1; 0: none. */
  number: number;
  stops: number;
  /** Of the text of this step, by language. */
  sentences: Record<string, string[]>;
  /** Which of them is said, in the language that the robot speaks, from 0. */
  sentence: number;
  /** What is said beside the text, in the language that the robot speaks; empty: nothing. */
  said: string;
  /** A picture or a video: `file` is below `media/`; null: none. */
  shown: ShownMedia | null;
  /** What the button `next` is called, by language. */
  press: Record<string, string>;
  /** That may be asked now. */
  questions: TourQuestion[];
  /** That the tour waits for. */
  buttons: ("agree" | "decline" | "next" | "start")[];
}

/** A wait until the first of what it names, or until its time is over. */
export interface Wait {
  /** Seconds after which the tour goes on in any case. */
  at_most_s: number;
  /** A word that is heard ends it, by language. */
  words: Record<string, string[]>;
  /** So many claps in a row end it. */
  claps: number | null;
  /** Somebody who calls out ends it: a loud noise while a voice is located. */
  call: boolean;
  /** A button with this text, on the page and for visitors, ends it. */
  press: Record<string, string> | null;
  /** It ends when all visitors have left. */
  all_left: boolean;
}

/** Every zone of the map. */
export interface ZoneList {
  zones: ZoneReport[];
}

/** A part of the map to keep out of, or to drive slowly in. */
export interface ZoneReport {
  /** What people call it; no two share one. */
  name: string;
  kind: "keep_out" | "slow";
  /** Its corners, x and y on the map (m). */
  polygon: [number, number][];
  /** Share of the robot's greatest speed allowed in it; means nothing to `keep_out`. */
  speed: number;
}

/** The picture ``seq`` of its kind was drawn. */
export interface AckMessage {
  type: "ack";
  kind: 1 | 2 | 3 | 4;
  seq: number;
}

/** Give the wheel to who asks for it, or keep it. */
export interface AnswerControlMessage {
  type: "answer_control";
  give: boolean;
}

/** Ask for the wheel. */
export interface AskControlMessage {
  type: "ask_control";
  t?: number | null;
  heard?: number | null;
  heard_t?: number | null;
}

/** A point of a picture of the camera. */
export interface CameraClick {
  /** Of the picture, at most 3 s old. */
  stamp: number;
  /** From its left edge, as a share of its width. */
  u: number;
  /** From its top edge, as a share of its height. */
  v: number;
}

/** Release the emergency stop. */
export interface ClearEStopMessage {
  type: "clear_e_stop";
  t?: number | null;
  heard?: number | null;
  heard_t?: number | null;
}

/** A change of a desire; members left out stay. */
export interface DesireChange {
  intensity?: number;
  utility?: number;
  security?: boolean;
  /** All parameters; they replace the former ones, and those left out take their default. */
  params?: Record<string, unknown>;
  /** Seconds from now; null: it stays. */
  ttl?: number | null;
}

/**
 * A drive command of the operator: of the base while ``held``, of the head while ``head_held``. Shares of the body's
 * limits: forward, turn left, sideways to the left; the head left and up.
 */
export interface DriveMessage {
  type: "drive";
  t?: number | null;
  heard?: number | null;
  heard_t?: number | null;
  seq: number;
  held: boolean;
  linear: number;
  angular: number;
  override?: boolean;
  lateral?: number;
  head_held?: boolean;
  pan?: number;
  tilt?: number;
}

/** Latch the emergency stop. */
export interface EStopMessage {
  type: "e_stop";
}

/** A goal for the robot: ``x`` and ``y``, or ``place``. */
export interface GoalRequest {
  /** On the map (m). */
  x?: number | null;
  /** On the map (m). */
  y?: number | null;
  /** Id of a place of the map, instead of `x`, `y` and `heading`. */
  place?: string | null;
  /** On the map (rad); null: any heading. */
  heading?: number | null;
  /** Share of the robot's greatest speed; null: as usual. */
  speed?: number | null;
}

/** How the link is shaped from now on; members left out shape nothing. */
export interface LinkChange {
  /** Added to a round trip, half of it each way. */
  delay_ms?: number;
  /** The delay varies by as much; at most the delay. */
  jitter_ms?: number;
  /** Packets that are lost and sent again. */
  loss_percent?: number;
  /** Mbit/s each way; null: not bounded. */
  rate_mbit?: number | null;
}

/** Subscribe to the microphones' sound, or end that. */
export interface ListenMessage {
  type: "listen";
  on: boolean;
}

/** How to take a map into use. */
export interface LoadRequest {
  /** Rough pose of the robot, within 1 m and 0.5 rad; null: global localization searches for it. */
  pose?: PoseRequest | null;
  /** Whether mapping continues in this map; else it is only localized in. */
  extend?: boolean;
}

/** The console's token, or the password of a role. */
export interface LoginRequest {
  token: string;
}

/**
 * Turn the head to a place in the camera's picture. ``stamp`` is the picture's (s); ``u`` and ``v`` are shares of its
 * width and height, from its upper left.
 */
export interface LookMessage {
  type: "look";
  t?: number | null;
  heard?: number | null;
  heard_t?: number | null;
  stamp: number;
  u: number;
  v: number;
}

/** A desire to create. */
export interface NewDesire {
  /** A class of GET /api/v1/desire-classes. */
  class: string;
  /** How much it is desired. */
  intensity: number;
  /** Utility desired; 0 inhibits the class. */
  utility: number;
  /** Whether it must be fulfilled. */
  security?: boolean;
  /** Parameters as the class declares them. */
  params?: Record<string, unknown>;
  /** Seconds after which it expires; null: it stays until removed. */
  ttl?: number | null;
}

/** A place to create. */
export interface NewPlace {
  /** For people; null: the poster's text, or a name with a number. */
  name?: string | null;
  /** By its coordinates. */
  pose?: PlacePose | null;
  /** Where the robot is now, with the heading that it has. */
  here?: boolean;
  /** In front of a poster, looking at it; it moves with the poster as the map is corrected. */
  poster?: PosterChoice | null;
  /** Never changes; null: made of the name. */
  id?: string | null;
}

/** A recording to make. */
export interface NewRecording {
  /** Empty: the date and time at which it begins. */
  name?: string;
  /** 0: all into one file; else the last so many minutes are kept. */
  keep_minutes?: number;
  /** How much it is desired. */
  intensity?: number;
  /** Utility desired: how full the recording must be at least. */
  utility?: number;
}

/** How a tour is rehearsed. */
export interface NewRehearsal {
  /** Of the visitors; left out: the tour's first. */
  language?: string | null;
  /** How many visitors follow. */
  people?: number;
  /** Of how they follow: the same again with the same. */
  seed?: number;
}

/** How a tour begins. */
export interface NewTourRun {
  /** Now, or when visitors or the schedule begin it, as the tour says, again and again. */
  begin?: "now" | "visitors";
  /** That the robot speaks; left out: the tour's first. */
  language?: string | null;
}

/** Ping; the pong returns ``t`` unchanged. */
export interface PingMessage {
  type: "ping";
  t?: number | null;
  heard?: number | null;
  heard_t?: number | null;
  rtt_ms?: number | null;
}

/** A change of a place; members left out stay. */
export interface PlaceChange {
  /** For people; no two places of a map share one. */
  name?: string;
  /** By hand: it follows no poster from then on. */
  pose?: PlacePose;
}

/** A pose on the map. */
export interface PlacePose {
  x: number;
  y: number;
  /** Heading on the map, left positive. */
  heading: number;
}

/** A change of the playback; members left out stay. */
export interface PlaybackChange {
  playing?: boolean | null;
  /** Seconds of the recording in a real second; null: as fast as possible, nothing dropped. */
  speed?: number | null;
  /** Go there (stamp of the recording, s). */
  position?: number | null;
}

/** A pose on the map. */
export interface PoseRequest {
  x: number;
  y: number;
  /** Heading on the map, left positive. */
  theta: number;
}

/** A poster (a QR code) that was found on the map. */
export interface PosterChoice {
  /** What it says. */
  text: string;
  /** x and y (m) on the map: of several with this text the nearest to there; null: the first. */
  near?: [number, number] | null;
}

/** Give the wheel back. */
export interface ReleaseControlMessage {
  type: "release_control";
}

/** A change of a map. */
export interface RenameRequest {
  /** The new name. */
  name: string;
}

/** A point of a route: a ``place``, or ``x`` and ``y``. */
export interface RoutePoint {
  /** Id of a place of the map in use. */
  place?: string | null;
  /** On the map (m). */
  x?: number | null;
  /** On the map (m). */
  y?: number | null;
  /** On the map (rad); null: any heading. */
  heading?: number | null;
}

/** Points to drive to, one after another. */
export interface RouteRequest {
  points: RoutePoint[];
  /** Share of the robot's greatest speed. */
  speed?: number;
}

/** The part of the ring to keep. */
export interface SaveRequest {
  /** The last so many; null: all there are. */
  minutes?: number | null;
  /** Empty: a name made of the time. */
  name?: string;
}

/** A point of a 3D view. */
export interface SceneClick {
  /** The view's name for itself, as `GET /viewers` lists it. */
  viewer: string;
  /** From its left edge, as a share of its width. */
  u: number;
  /** From its top edge, as a share of its height. */
  v: number;
}

/** What the strongest desire of a class is supposed to ask for. */
export interface SupposedDesire {
  intensity: number;
  /** 0 inhibits the class. */
  utility?: number;
  security?: boolean;
}

/** Take the wheel at once. */
export interface TakeControlMessage {
  type: "take_control";
  t?: number | null;
  heard?: number | null;
  heard_t?: number | null;
}

/**
 * A message that says when it was sent. ``t``: by the page's clock (ms). ``heard``: the stamp of the newest ``hello``,
 * ``status`` or ``pong`` that the page had received (s), ``heard_t``: when that came, by the page's clock (ms). None:
 * it does not say.
 */
export interface TimedMessage {
  t?: number | null;
  heard?: number | null;
  heard_t?: number | null;
}

/** One thing that is done with the tour under way. */
export interface TourPress {
  /** A button, one of `buttons` now. */
  button?:
    | "start"
    | "agree"
    | "decline"
    | "next"
    | "pause"
    | "resume"
    | "retry"
    | "skip"
    | "undo_skip"
    | "repeat"
    | "end"
    | null;
  /** Id of a stop to go to. */
  stop?: string | null;
  /** Id of a question that a visitor asks, one of `questions` now. */
  ask?: string | null;
}

/**
 * Which pictures the page shows; None: unchanged. ``camera_px``: so many pixels wide it shows the camera's. ``vp9``:
 * whether it decodes them as VP9, too.
 */
export interface ViewMessage {
  type: "view";
  camera?: boolean | null;
  panorama?: boolean | null;
  map?: boolean | null;
  costmap?: boolean | null;
  camera_px?: number | null;
  vp9?: boolean | null;
}

/** The key of a link for visitors. */
export interface VisitorKey {
  key: string;
}

/** One thing that a visitor presses. */
export interface VisitorPress {
  /** One of `buttons` now. */
  button?: "start" | "agree" | "decline" | "next" | null;
  /** Id of a question, one of `questions` now. */
  ask?: string | null;
}

/** What is supposed; all else is as it is. */
export interface WhatIf {
  /** By class; null: none of that class. */
  desires?: Record<string, SupposedDesire | null>;
  /** By strategy and resource. */
  costs?: Record<string, Record<string, number>>;
  /** By resource. */
  capacities?: Record<string, number>;
}

/** A part of the map with a rule for driving in it. */
export interface ZoneRequest {
  /** Unique name for people. */
  name: string;
  /** The robot keeps out of it, or drives slowly in it. */
  kind: "keep_out" | "slow";
  /** Its corners, x and y on the map (m). */
  polygon: [number, number][];
  /** Share of the robot's greatest speed allowed in it; means nothing to `keep_out`. */
  speed?: number;
}

/** Every zone of the map. */
export interface ZonesRequest {
  zones: ZoneRequest[];
}

/** The robot's messages by `type`. */
export interface RobotMessages {
  /** Once, first: what can be seen and done here. */
  hello: Hello;
  /** 20 times a second: guard, pose, driver, freshness of every source. */
  status: Status;
  /** 10 times a second: one row for each desire class. */
  lanes: Lanes;
  /** Once, before the first `lanes`, and after a `jump`: what they were. */
  lanes_history: LanesHistory;
  /** On change: every desire. */
  desires: Desires;
  /** On change, from the first on: what attention chose. */
  intention: IntentionReport;
  /** As they come: events, oldest first. */
  events: EventList;
  /** Once a second: what the modules take of the computer. */
  load: LoadReport;
  /** On change, and once a second while it records: the Recorder. */
  recorder: RecorderReport;
  /** On change: what was found, each in its `frame`. */
  landmarks: LandmarkList;
  /** On change: what the robot sees and hears. */
  perceived: PlacedPercepts;
  /** When a rule applies, and when files of rules change: every rule. */
  rules: RulesReport;
  /** On change, up to 20 times a second: what the robot says, for subtitles. */
  speech: Speech;
  /** Once a second, of a body with a battery: its charge. */
  battery: BatteryState;
  /** As they come: an utterance while words are listened for. */
  heard_words: HeardWords;
  /** Five times a second while it is desired: what stands out around. */
  salient_regions: SalientRegions;
  /** With it: how salient all directions are. */
  saliency: SaliencyMap;
  /** 10 times a second while it is desired: who is around, in `odom`. */
  persons: Persons;
  /** Up to 10 times a second: where the robot is on the map. */
  localization: LocalizationReport;
  /** On change: the goal and the state of navigation. */
  navigation: NavigationModel;
  /** On change: the zones of the map. */
  zones: ZoneList;
  /** On change: the places of the map. */
  places: PlaceList;
  /** On change: how the guided tour goes. */
  tour: TourProgress;
  /** On change, at most once a second: what is felt, and what it comes from. */
  emotions: EmotionState;
  /** On change, up to 4 times a second: what is recognized, expected, remembered. */
  memory: MemoryState;
  /** Right before each picture of kind 3 (map): what it shows. */
  map_info: GridInfo;
  /** Right before each picture of kind 4 (costmap): what it shows. */
  costmap_info: GridInfo;
  /** The answer to `ping`. */
  pong: Pong;
  /** Something for this viewer, in words to show. */
  notice: Notice;
  /** On a recording, at every change and ten times a second while it plays: its transport. */
  playback: PlaybackReport;
  /** On a recording, at a seek: what came before is of another time and to be forgotten. */
  jump: Jump;
  /** On change: how the link to the pages is shaped, for tests. */
  link: LinkReport;
}

export type FromRobot = { [T in keyof RobotMessages]: { type: T } & RobotMessages[T] }[keyof RobotMessages];

export type ToRobot =
  | DriveMessage
  | LookMessage
  | EStopMessage
  | ClearEStopMessage
  | TakeControlMessage
  | ReleaseControlMessage
  | PingMessage
  | AckMessage
  | ViewMessage
  | ListenMessage
  | AskControlMessage
  | AnswerControlMessage;
