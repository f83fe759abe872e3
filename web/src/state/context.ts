/** What every component may use: the store, the session with the robot, the driving, the pictures, the sound, the map. */

import type { ReadonlySignal } from "@preact/signals";
import { createContext } from "preact";
import { useContext } from "preact/hooks";
import type { Ahead } from "../drive/ahead";
import type { DriveController } from "../drive/driveController";
import type { LayoutControl } from "../layout/layoutControl";
import type { GridFeed } from "../map/gridFeed";
import type { MapLibrary } from "../map/library";
import type { MapControl } from "../map/mapControl";
import type { PlaceControl } from "../map/placeControl";
import type { PlaybackController } from "../playback/playbackController";
import type { RecordingControl } from "../recordings/recordingControl";
import type { Listening } from "../sound/listening";
import type { Talking } from "../sound/talking";
import type { RehearsalControl } from "../tours/rehearsalControl";
import type { RouteControl } from "../tours/routeControl";
import type { StopMaker } from "../tours/stopMaker";
import type { TourControl } from "../tours/tourControl";
import type { TourDrive } from "../tours/tourDrive";
import type { TourMarks } from "../tours/tourMarks";
import type { TourPointing } from "../tours/tourPointing";
import type { TourRunControl } from "../tours/tourRunControl";
import type { TourTrial } from "../tours/tourTrial";
import type { PictureFeed } from "../view/pictureFeed";
import type { Session } from "./session";
import type { Store } from "./store";

export interface App {
  store: Store;
  session: Session;
  drive: DriveController;
  /** Where the robot will be when a command given now arrives. */
  ahead: Ahead;
  camera: PictureFeed;
  panorama: PictureFeed;
  listening: Listening;
  talking: Talking;
  playback: PlaybackController;
  recordings: RecordingControl;
  map: MapControl;
  /** The kept maps. */
  maps: MapLibrary;
  /** The places of the map in use. */
  places: PlaceControl;
  /** The tours, and the one that is edited. */
  tours: TourControl;
  /** Its way. */
  tourRoute: RouteControl;
  /** Makes its stops. */
  stops: StopMaker;
  tourPointing: TourPointing;
  tourTrial: TourTrial;
  /** The tour that is led. */
  tourRun: TourRunControl;
  /** A rehearsal of the edited one. */
  rehearsal: RehearsalControl;
  /** A tour that is configured by driving. */
  tourDrive: TourDrive;
  /** What of the edited one is drawn on the map; null: nothing. */
  tourMarks: ReadonlySignal<TourMarks | null>;
  /** How the page is divided. */
  layout: LayoutControl;
  /** The pictures of map and local costmap. */
  grid: { map: GridFeed; costmap: GridFeed };
}

export const AppContext = createContext<App | null>(null);

export function useApp(): App {
  const app = useContext(AppContext);
  if (!app) throw new Error("useApp outside of the page's AppContext");
  return app;
}
