/** Starts the page. */

import { computed, effect } from "@preact/signals";
import { render } from "preact";
import { App } from "./App";
import { lookAhead } from "./drive/ahead";
import { DriveController } from "./drive/driveController";
import { t } from "./i18n";
import { startLanguage, thisReader } from "./i18n/language";
import { LayoutControl } from "./layout/layoutControl";
import { startTheme } from "./layout/theme";
import { GridFeed } from "./map/gridFeed";
import { MapLibrary } from "./map/library";
import { MapControl } from "./map/mapControl";
import { PlaceControl } from "./map/placeControl";
import { PlaybackController } from "./playback/playbackController";
import { CAMERA, PANORAMA } from "./protocol/picture";
import { RecordingControl } from "./recordings/recordingControl";
import { Listening } from "./sound/listening";
import { Talking } from "./sound/talking";
import { AppContext } from "./state/context";
import { keepHistory } from "./state/history";
import { Session } from "./state/session";
import { createStore } from "./state/store";
import { accelerated } from "./state/turns";
import { RehearsalControl } from "./tours/rehearsalControl";
import { RouteControl } from "./tours/routeControl";
import { StopMaker } from "./tours/stopMaker";
import { TourControl } from "./tours/tourControl";
import { TourDrive } from "./tours/tourDrive";
import { TourPointing } from "./tours/tourPointing";
import { TourRunControl } from "./tours/tourRunControl";
import { TourTrial } from "./tours/tourTrial";
import { narrow } from "./ui/media";
import { PictureFeed } from "./view/pictureFeed";
import "./styles/base.css";
import "./styles/parts.css";
import "./styles/layout.css";
import "./styles/overlays.css";
import "./styles/bar.css";
import "./styles/view.css";
import "./styles/memory.css";
import "./styles/around.css";
import "./styles/senses.css";
import "./styles/view-tools.css";
import "./styles/drive.css";
import "./styles/lanes.css";
import "./styles/lane-names.css";
import "./styles/legend.css";
import "./styles/tooltip.css";
import "./styles/panels.css";
import "./styles/what-if.css";
import "./styles/load.css";
import "./styles/graph.css";
import "./styles/forms.css";
import "./styles/transport.css";
import "./styles/recordings.css";
import "./styles/map.css";
import "./styles/zones.css";
import "./styles/kept-maps.css";
import "./styles/tours.css";
import "./styles/tour-media.css";
import "./styles/tour-drive.css";
import "./styles/tour-run.css";
import "./styles/rehearsal.css";
import "./styles/narrow.css";
import "./styles/dock.css";
import "./styles/touch.css";
import "./styles/access.css";
import "./styles/small.css";

const store = createStore();
const stopWorker = new Worker(new URL("./drive/stopWorker.ts", import.meta.url), { type: "module" });
const session = new Session(store, (order) => stopWorker.postMessage(order));
keepHistory(session, store);
const playback = new PlaybackController(store, session.rest);
const recordings = new RecordingControl(store, session.rest);
const drive = new DriveController(store, session, playback);
const ahead = lookAhead(store, session, drive);
const processorDraws = !accelerated();
document.documentElement.dataset["drawn"] = processorDraws ? "processor" : "card";
const camera = new PictureFeed(
  session,
  CAMERA,
  computed(() => store.camera.value !== "hidden" && store.around.value !== "large"),
  computed(() => processorDraws && !store.replay.value && !store.steered.value),
);
const panorama = new PictureFeed(
  session,
  PANORAMA,
  computed(() => {
    const mode = store.around.value;
    return mode === "large" || (mode === "inset" && (!narrow.value || store.tab.value === "found"));
  }),
  computed(() => processorDraws && !store.replay.value),
);
panorama.canvas = document.createElement("canvas");
const listening = new Listening(store, session);
const map = new MapControl(store, session);
const toursShown = computed(() => store.body.value.maps && store.tab.value === "tour");
const mapsShown = computed(() => map.shown.value || toursShown.value);
const maps = new MapLibrary(store, session.rest, mapsShown, () => map.desireMap());
const places = new PlaceControl(store, session.rest);
const tours = new TourControl(store, session.tourRest, toursShown);
const tourRoute = new RouteControl(session.rest, {
  draft: tours.draft,
  places: places.all,
  zones: map.zones,
  map: maps.inUse,
  able: computed(() => tours.allowed.value && store.body.value.goes),
});
const stops = new StopMaker(store, session.rest, places, tours);
const tourPointing = new TourPointing(store, session.rest, map, tours);
const tourRun = new TourRunControl(store, session.tourRest, tours);
const tourTrial = new TourTrial(store, session.rest);
const tourDrive = new TourDrive(store, session.rest, map, maps, places, tours);
const rehearsal = new RehearsalControl(session.tourRest, tours);
const tourMarks = computed(() => {
  const tour = tours.draft.value;
  if (!tour || !toursShown.value || (maps.inUse.value !== null && maps.inUse.value !== tour.map)) return null;
  return {
    tour,
    legs: tourRoute.legs.value,
    places: places.all.value,
    open: stops.open.value,
    rehearsed: rehearsal.mark.value,
  };
});
const grid = {
  map: new GridFeed(session, "map", map.shown),
  costmap: new GridFeed(
    session,
    "costmap",
    computed(() => map.shown.value && map.costmap.value),
  ),
};
const talking = new Talking(store, session, listening);
const layout = new LayoutControl(store, localStorage);
layout.start(location.search);
startTheme(document.documentElement, localStorage);
await startLanguage(thisReader());

render(
  <AppContext.Provider
    value={{
      store,
      session,
      drive,
      ahead,
      camera,
      panorama,
      listening,
      talking,
      playback,
      recordings,
      map,
      maps,
      places,
      tours,
      tourRoute,
      stops,
      tourPointing,
      tourTrial,
      tourRun,
      rehearsal,
      tourDrive,
      tourMarks,
      layout,
      grid,
    }}
  >
    <App />
  </AppContext.Provider>,
  document.getElementById("app")!,
);
drive.onHome = () => void map.returnToStart();
drive.onStop = () => map.stop();
map.start(); // before the driving keys: Escape cancels the map's tool first
drive.start();
recordings.start();
camera.start();
panorama.start();
grid.map.start();
grid.costmap.start();
maps.start();
map.onSelect = (at, scale) => stops.pick(at, scale);
tours.start();
tourRoute.start();
tourPointing.start();
tourDrive.start();
tourRun.start();
rehearsal.start();
listening.start();
talking.start();
void session.start();

// A new name needs a new connection.
let named = store.operator.peek();
effect(() => {
  const name = store.operator.value;
  if (name === named) return;
  named = name;
  void session.enter();
});
effect(() => {
  const robot = store.hello.value?.robot.name;
  const what = robot && store.replay.value ? t("Recording of {robot}", { robot }) : robot;
  document.title = what ? t("{what} · HBBA console", { what }) : t("HBBA console");
});
