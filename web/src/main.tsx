/** Starts the page. */

import { effect } from "@preact/signals";
import { render } from "preact";
import { App } from "./App";
import { DriveController } from "./drive/controller";
import { AppContext } from "./state/context";
import { Session } from "./state/session";
import { createStore } from "./state/store";
import { CameraFeed } from "./view/feed";
import "./styles/base.css";
import "./styles/parts.css";
import "./styles/layout.css";
import "./styles/overlays.css";
import "./styles/bar.css";
import "./styles/view.css";
import "./styles/drive.css";
import "./styles/lanes.css";
import "./styles/tooltip.css";
import "./styles/panels.css";
import "./styles/load.css";
import "./styles/forms.css";
import "./styles/narrow.css";
import "./styles/dock.css";

const store = createStore();
const session = new Session(store);
const drive = new DriveController(store, session);
const camera = new CameraFeed(store, session);

render(
  <AppContext.Provider value={{ store, session, drive, camera }}>
    <App />
  </AppContext.Provider>,
  document.getElementById("app")!,
);
drive.start();
camera.start();
void session.start();

// A new name is told with a new connection.
let named = store.operator.peek();
effect(() => {
  const name = store.operator.value;
  if (name === named) return;
  named = name;
  void session.enter();
});
effect(() => {
  const robot = store.hello.value?.robot.name;
  document.title = robot ? `${robot} · HBBA console` : "HBBA console";
});
