/** The records of `generated.ts`, some of them under the page's own names, and what follows from them. */

import type {
  FromRobot as Declared,
  FaceReport,
  GridInfo as Grid,
  LaneRow,
  Notice,
  TimedMessage,
  VisitorLink,
  VisitorView,
} from "./generated";

export type {
  DesireClassReport as DesireClass,
  DriveMessage as DriveCommand,
  GoalPoseModel as GoalPlace,
  IntentionReport as Intention,
  LandmarkReport as Landmark,
  LoadReport as Load,
  MapList as KeptMaps,
  ModuleReport as ModuleLoad,
  NavigationModel as Navigation,
  PlacedCode as SeenCode,
  PlacedFace as SeenFace,
  PlacedPercepts as Perceived,
  PlacedSound as HeardSound,
  PlaceReport as Place,
  PlaybackReport as Playback,
  RecorderReport as Recorder,
  RecordingList as Recordings,
  RecordingReport as Recording,
  TimelineEvent as RobotEvent,
  ZoneReport as Zone,
} from "./generated";
export * from "./generated";
export type { JsonSchema } from "./jsonSchema";

/** The newest message of a channel that a panel of a package named; the package declares its shape. */
export type ChannelFrame = { type: "channel"; channel: string; message: { stamp: number } };

/** Where the joints of the face are, on the stream of the face. */
export type FaceFrame = { type: "face" } & FaceReport;

/** The way in for visitors' phones, on the stream of the face. */
export type VisitorLinkFrame = { type: "visitor_link" } & VisitorLink;

/** How a tour goes for visitors, on their own stream. */
export type VisitorFrame = { type: "visitor" } & VisitorView;

export type FromRobot = Declared | ChannelFrame | FaceFrame | VisitorLinkFrame | VisitorFrame;

export type LaneState = LaneRow["state"];

/** By filter; null: closed. */
export type Divisors = Readonly<LaneRow["divisors"]>;

/** Azimuth (left positive) and elevation (up positive), rad. */
export type Direction = [azimuth: number, elevation: number];

export type GridInfo = { type: "map_info" | "costmap_info" } & Grid;

export type NoticeLevel = Notice["level"];

/** When a message was sent (page's clock, ms), the robot's newest stamp by then, and when that had come (page's, ms). */
export type Timed = Pick<TimedMessage, "t" | "heard" | "heard_t">;
