/** What crosses the live stream and REST, as in docs/live-stream.md. Stamps are the robot's clock, in seconds. */

export interface Limits {
  linear_mps: number;
  angular_radps: number;
  linear_mps2: number;
  angular_radps2: number;
}

export interface Velocity {
  linear_mps: number;
  angular_radps: number;
}

/** The part of JSON Schema that parameter models use. */
export interface JsonSchema {
  type?: string | string[];
  title?: string;
  description?: string;
  default?: unknown;
  enum?: unknown[];
  const?: unknown;
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  exclusiveMaximum?: number;
  multipleOf?: number;
  minLength?: number;
  maxLength?: number;
  pattern?: string;
  properties?: Record<string, JsonSchema>;
  required?: string[];
  anyOf?: JsonSchema[];
  allOf?: JsonSchema[];
  $ref?: string;
  $defs?: Record<string, JsonSchema>;
}

export interface DesireClass {
  name: string;
  title: string;
  description: string;
  schema: JsonSchema;
  /** Whether a strategy of the program's modules serves it. */
  served: boolean;
}

/** What people must know of how the program is configured. */
export interface Caution {
  title: string;
  text: string;
  /** File and line. */
  where: string;
}

export interface Robot {
  name: string;
  simulated: boolean;
  /** It lives a recording again. */
  replayed: boolean;
  limits: Limits;
  /** Its outline on the floor, corners in `base_link` (m); empty for a body that does not move. */
  footprint: [number, number][];
  cautions: Caution[];
}

export interface Hello {
  type: "hello";
  protocol: number;
  session: string;
  stamp: number;
  robot: Robot;
  scale: { intensity: number; utility: number };
  classes: DesireClass[];
  channels: {
    camera: boolean;
    panorama: boolean;
    map: boolean;
    costmap: boolean;
    scan: boolean;
    point_cloud: boolean;
  };
  /** Whether hands can drive here. */
  drive: boolean;
  /** Whether the robot can be listened to, and be spoken through. */
  audio: { listen: boolean; speak: boolean };
  /** Where this page shows a recording instead of a living robot. */
  playback: Omit<Playback, "type"> | null;
}

/** A replay's transport. `position`, `begin` and `end` are stamps of the recording; a null `speed` is the machine's. */
export interface Playback {
  type: "playback";
  file: string;
  begin: number;
  end: number;
  position: number;
  speed: number | null;
  playing: boolean;
  phase: "playing" | "paused" | "ended" | "seeking";
  /** What cannot be read of the recording here, why it stands. */
  problem?: string | null;
}

export interface Recorder {
  type: "recorder";
  stamp: number;
  state: "idle" | "recording" | "ring" | "stopped";
  name: string;
  /** The robot's clock when it began; null while idle. */
  began: number | null;
  duration_s: number;
  bytes: number;
  messages: number;
  dropped: number;
  /** What waits for the disk now. */
  queued_bytes: number;
  /** Of the ring; 0: everything goes into one file. */
  keep_minutes: number;
  /** Whether anybody desires a recording. */
  desired: boolean;
  /** Why it does not record though it is desired, in words. */
  reason: string;
  /** Whether it runs and attention has a strategy for it. */
  available: boolean;
}

export interface Recording {
  name: string;
  bytes: number;
  duration_s: number | null;
  /** Unix time. */
  began: number | null;
  state: "complete" | "recording" | "unfinished";
  /** Empty where the file does not say. */
  robot: string;
}

export interface Recordings {
  folder: string;
  free_bytes: number | null;
  recorder: Omit<Recorder, "type"> | null;
  /** The replay that the robot's console started, while it runs. */
  replay: { name: string; url: string } | null;
  recordings: Recording[];
}

export interface Guard {
  state: string;
  reason: string;
  e_stopped: boolean;
  command_age_ms: number | null;
  applied: Velocity;
}

export interface SourceState {
  channel: string;
  state: "live" | "stale" | "closed" | "waiting";
  age_ms: number | null;
  rate_hz: number | null;
  expected_hz: number | null;
}

export interface Status {
  type: "status";
  seq: number;
  stamp: number;
  guard: Guard;
  world_rate: number;
  odometry: ({ x: number; y: number; theta: number } & Velocity) | null;
  /** Who has the wheel; `holds`: they hold a command just now (absent from older programs). */
  driver: { operator: string; mine: boolean; holds?: boolean } | null;
  /** Who speaks through the robot. */
  speaker?: { operator: string; mine: boolean } | null;
  exploited: string | null;
  /** Why the collision monitor slowed or stopped the robot; empty: it did not. Absent from older programs. */
  limited?: string;
  /** Why this page's driving waits: its commands come late; empty: it does not. Absent from older programs. */
  waits?: string;
  sources: SourceState[];
}

export type LaneState = "fulfilled" | "degraded" | "unfulfilled" | "inhibited" | "undesired" | "needed";

export interface LaneRow {
  class: string;
  intensity: number | null;
  utility: number | null;
  rate: number | null;
  divisor: number | null;
  /** φ by filter (`Module.port`) of the strategies at work; absent from older programs. */
  divisors?: Divisors;
  state: LaneState;
  text: string;
}

/** By filter; null: closed. */
export type Divisors = Readonly<Record<string, number | null>>;

export interface Lanes {
  type: "lanes";
  seq: number;
  stamp: number;
  rows: LaneRow[];
}

/** A class's values from sample `at` until its next spell. */
export type LaneSpell = Omit<LaneRow, "class" | "rate"> & { at: number };

/** The lanes before this page came: one rate for each stamp, the rest as it changed. */
export interface LanesHistory {
  type: "lanes_history";
  stamps: number[];
  rows: { class: string; rate: (number | null)[]; spells: LaneSpell[] }[];
}

export interface Desire {
  id: string;
  class: string;
  intensity: number;
  utility: number;
  security: boolean;
  params: Record<string, unknown>;
  source: { kind: string; name: string };
  created: number;
  expires: number | null;
}

export interface SelectedStrategy {
  name: string;
  class: string;
  utility: number;
  filters: Record<string, number | null>;
  costs: Record<string, number>;
}

export interface Reason {
  state: string;
  utility: number | null;
  wanted: number | null;
  /** The most utility that its strategies can produce. */
  best: number | null;
  text: string;
  alternatives: unknown[];
}

export interface Intention {
  stamp: number;
  strategies: SelectedStrategy[];
  fulfilled: string[];
  omega: number;
  /** What no selection can exceed. */
  bound: number;
  use: Record<string, { used: number; capacity: number; unit: string }>;
  filters: Record<string, number | null>;
  proven: boolean;
  solve_ms: number;
  relaxed: string[];
  reasons: Record<string, Reason>;
  /** By module. */
  parameters: Record<string, Record<string, unknown>>;
  /** Ids, by class. */
  desires: Record<string, string>;
}

export interface RobotEvent {
  id: number | string;
  stamp: number;
  kind: string;
  subject: string | null;
  text: string;
  data?: Record<string, unknown> | null;
}

export interface ModuleInput {
  name: string;
  channel: string;
  divisor: number | null;
  received: number;
  passed: number;
  decimated: number;
  dropped: number;
  age_ms: number | null;
}

/** `channel` is null where nothing is connected. */
export interface ModuleOutput {
  name: string;
  channel: string | null;
  divisor: number | null;
  offered: number;
}

export interface ModuleLoad {
  name: string;
  title: string;
  state: "running" | "starting" | "failed" | "hung" | "stopped";
  cpu: number;
  /** What the module is expected to stay under, where it says so. */
  cpu_budget?: number | null;
  message_cpu_us: number | null;
  restarts: number;
  problem: string | null;
  inputs: ModuleInput[];
  outputs: ModuleOutput[];
}

export interface Load {
  type: "load";
  stamp: number;
  process_cpu: number;
  budget: number | null;
  modules: ModuleLoad[];
}

export interface Landmark {
  text: string;
  x: number;
  y: number;
  z: number;
  sigma_m: number;
  sightings: number;
  first_seen: number;
  last_seen: number;
}

/** Azimuth (left positive) and elevation (up positive), rad. */
export type Direction = [azimuth: number, elevation: number];

/** Where something was perceived: angles in the robot's axes, its place in `odom` (m). What is not known is null. */
interface Percept {
  track: number;
  stamp: number;
  azimuth: number;
  elevation: number;
  /** Where it is on the panorama; null while there was no such picture. */
  panorama: Direction | null;
  range_m: number | null;
  range_sigma_m: number | null;
  x: number | null;
  y: number | null;
  z: number | null;
}

export interface SeenFace extends Percept {
  /** The frame of the image it was seen in. */
  camera: string;
  score: number;
  /** Left, top, width and height, px of `image`. */
  box: [number, number, number, number];
  image: [width: number, height: number];
}

export interface HeardSound extends Percept {
  power: number;
  level_db: number;
  /** Whether it sounds now. */
  active: boolean;
  last_active: number;
  /** Probability that it is a voice. */
  speech: number | null;
}

export interface Noise {
  stamp: number;
  ratio: number;
  level_db: number;
}

/** A QR code read in one image: its four corners in px. */
export interface SeenCode {
  text: string;
  camera: string;
  stamp: number;
  corners: [number, number][];
  image: [number, number];
}

export interface Perceived {
  type: "perceived";
  stamp: number;
  faces: SeenFace[];
  sounds: HeardSound[];
  noises: Noise[];
  codes: SeenCode[];
}

export interface Place {
  x: number;
  y: number;
  theta: number;
}

/** Where the robot is on the map: `X_MO` places `odom` there. Standard deviations of x, y (m) and theta (rad). */
export interface Localization {
  type: "localization";
  stamp: number;
  state: "mapping" | "tracking" | "searching" | "lost";
  /** Of the map in use; empty while it has none. */
  map: string;
  x: number;
  y: number;
  theta: number;
  sigma: [number, number, number];
  X_MO: Place;
  /** Share of the scan that fits the map. */
  overlap: number;
}

export type GoalPlace = Omit<Place, "theta"> & { theta: number | null };

/** What a behavior that goes somewhere is about; places on the map. */
export interface Navigation {
  type: "navigation";
  stamp: number;
  behavior: string;
  state: "idle" | "planning" | "following" | "recovering" | "waiting" | "arrived" | "unreachable";
  reason: string;
  goal: GoalPlace | null;
  /** Where it really goes: the nearest place to the goal that can be reached. */
  target: GoalPlace | null;
  remaining_m: number | null;
  recoveries: number;
  /** Of the desire it serves. */
  desire: string | null;
  path: [number, number][];
  /** The goal that the robot gave up last, until there is another; absent from older programs. */
  given_up?: { stamp: number; goal: GoalPlace; reason: string } | null;
}

/** A part of the map to keep out of, or to drive slowly in: at `speed`, a share of the greatest. */
export interface Zone {
  name: string;
  kind: "keep_out" | "slow";
  polygon: [number, number][];
  speed: number;
}

/** A map in the robot's folder. */
export interface KeptMap {
  name: string;
  in_use: boolean;
  /** Unix time. */
  saved: number;
  size_m: [width: number, height: number];
  resolution_m: number;
  known_m2: number;
  /** Whether mapping can go on from it. */
  extendable: boolean;
  zones: number;
  /** Why it cannot be used. */
  problem: string | null;
}

export interface KeptMaps {
  folder: string;
  /** The map in use; not `available` where this program makes none. */
  current: { available: boolean; name: string; state: Localization["state"] | null };
  maps: KeptMap[];
}

/** What the grey picture of the same `seq` shows: cell sizes and where its lower left corner is in `frame`. */
export interface GridInfo {
  type: "map_info" | "costmap_info";
  seq: number;
  stamp: number;
  frame: string;
  version: number;
  resolution_m: number;
  origin: [number, number];
  width: number;
  height: number;
}

export type NoticeLevel = "info" | "warning" | "error";

export type FromRobot =
  | Hello
  | Status
  | Lanes
  | LanesHistory
  | Load
  | { type: "desires"; desires: Desire[] }
  | { type: "intention"; intention: Intention | null }
  | { type: "events"; events: RobotEvent[] }
  | { type: "landmarks"; landmarks: Landmark[] }
  | Perceived
  | Playback
  | { type: "jump"; stamp: number }
  | Recorder
  | Localization
  | Navigation
  | { type: "zones"; zones: Zone[] }
  | GridInfo
  | { type: "pong"; t: number; stamp: number }
  | { type: "channel"; channel: string; message: { stamp: number } }
  | { type: "notice"; level: NoticeLevel; text: string };

/** When a message was sent (page's clock, ms), the robot's newest stamp by then, and when that had come (page's, ms). */
export interface Timed {
  t: number;
  heard?: number;
  heard_t?: number;
}

export interface DriveCommand {
  type: "drive";
  seq: number;
  held: boolean;
  linear: number;
  angular: number;
  /** Held too: what stands in the way stops nothing, and the robot crawls. */
  override?: boolean;
}

export type ToRobot =
  | DriveCommand
  | { type: "e_stop" }
  | { type: "clear_e_stop" }
  | { type: "take_control" }
  | { type: "release_control" }
  | { type: "ping"; rtt_ms: number | null }
  | { type: "ack"; kind: number; seq: number }
  | { type: "view"; camera?: boolean; panorama?: boolean; map?: boolean; costmap?: boolean }
  | { type: "listen"; on: boolean };
