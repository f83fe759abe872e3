/** What every component may use: the store, the session with the robot, the driving, the pictures, the sound, the map. */

import { createContext } from "preact";
import { useContext } from "preact/hooks";
import type { DriveController } from "../drive/driveController";
import type { GridFeed } from "../map/gridFeed";
import type { MapLibrary } from "../map/library";
import type { MapControl } from "../map/mapControl";
import type { PlaceControl } from "../map/placeControl";
import type { PlaybackController } from "../playback/playbackController";
import type { RecordingControl } from "../recordings/recordingControl";
import type { Listening } from "../sound/listening";
import type { Talking } from "../sound/talking";
import type { PictureFeed } from "../view/pictureFeed";
import type { Session } from "./session";
import type { Store } from "./store";

export interface App {
  store: Store;
  session: Session;
  drive: DriveController;
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
  /** The pictures of map and local costmap. */
  grid: { map: GridFeed; costmap: GridFeed };
}

export const AppContext = createContext<App | null>(null);

export function useApp(): App {
  const app = useContext(AppContext);
  if (!app) throw new Error("useApp outside of the page's AppContext");
  return app;
}
