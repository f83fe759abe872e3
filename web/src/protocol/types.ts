/** The records of `generated.ts`, some of them under the page's own names, and what follows from them. */

import type { GridInfo as Grid, LaneRow, Notice, TimedMessage } from "./generated";

export * from "./generated";
export type { JsonSchema } from "./jsonSchema";
export type {
  CodeModel as SeenCode,
  DesireClassModel as DesireClass,
  DesireModel as Desire,
  DriveMessage as DriveCommand,
  EventModel as RobotEvent,
  FaceModel as SeenFace,
  IntentionModel as Intention,
  LandmarkModel as Landmark,
  MapList as KeptMaps,
  MapModel as KeptMap,
  ModuleModel as ModuleLoad,
  NavigationModel as Navigation,
  PerceptsModel as Perceived,
  PlaceModel as GoalPlace,
  PlaybackModel as Playback,
  RecorderModel as Recorder,
  RecordingList as Recordings,
  RecordingModel as Recording,
  SoundModel as HeardSound,
  CautionModel as Caution,
  ZoneModel as Zone,
} from "./generated";

export type LaneState = LaneRow["state"];

/** By filter; null: closed. */
export type Divisors = Readonly<LaneRow["divisors"]>;

/** Azimuth (left positive) and elevation (up positive), rad. */
export type Direction = [azimuth: number, elevation: number];

export type GridInfo = { type: "map_info" | "costmap_info" } & Grid;

export type NoticeLevel = Notice["level"];

/** When a message was sent (page's clock, ms), the robot's newest stamp by then, and when that had come (page's, ms). */
export type Timed = Pick<TimedMessage, "t" | "heard" | "heard_t">;
