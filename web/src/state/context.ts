/** What every component may use: the store, the session with the robot, the hands, the camera. */

import { createContext } from "preact";
import { useContext } from "preact/hooks";
import type { DriveController } from "../drive/controller";
import type { PlaybackController } from "../playback/controller";
import type { RecordingControl } from "../recordings/control";
import type { CameraFeed } from "../view/feed";
import type { Session } from "./session";
import type { Store } from "./store";

export interface App {
  store: Store;
  session: Session;
  drive: DriveController;
  camera: CameraFeed;
  playback: PlaybackController;
  recordings: RecordingControl;
}

export const AppContext = createContext<App | null>(null);

export function useApp(): App {
  const app = useContext(AppContext);
  if (!app) throw new Error("useApp outside of the page's AppContext");
  return app;
}
