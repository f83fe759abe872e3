/** The page: bar, view, side, lanes; stacked on a phone. */

import { Around } from "./around/Around";
import { DesireForm } from "./desires/DesireForm";
import { DesireList } from "./desires/DesireList";
import { DrivePad } from "./drive/DrivePad";
import { Lanes } from "./lanes/Lanes";
import { MapPanel } from "./map/MapPanel";
import { Maps } from "./map/Maps";
import { Zones } from "./map/Zones";
import { Events } from "./panels/Events";
import { externalTabs } from "./panels/external";
import { Found } from "./panels/Found";
import { Intention } from "./panels/Intention";
import { Load } from "./panels/Load";
import { People } from "./panels/People";
import { Transport } from "./playback/Transport";
import { Recordings } from "./recordings/Recordings";
import { ListenButton } from "./sound/ListenButton";
import { TalkButton } from "./sound/TalkButton";
import { useApp } from "./state/context";
import { Banner } from "./ui/Banner";
import { EStop } from "./ui/EStop";
import { Help } from "./ui/Help";
import { CubeIcon, MapIcon } from "./ui/icons";
import { Login } from "./ui/Login";
import { narrow } from "./ui/media";
import { Notices } from "./ui/Notices";
import { Skips } from "./ui/Skips";
import { type TabItem, Tabs } from "./ui/Tabs";
import { TopBar } from "./ui/TopBar";
import { Camera } from "./view/Camera";
import { SceneView } from "./view/SceneView";

export function App() {
  const { store } = useApp();
  const phase = store.link.value.phase;
  if (phase === "login") return <Login />;
  const phone = narrow.value;
  const replay = store.replay.value;
  const stopped = store.stopped.value && !replay;
  const body = store.body.value;
  const mapped = body.maps && store.mapPlace.value === "view";
  // What a body cannot do is not offered; of a recording it is told why not.
  const audio = store.hello.value?.audio;
  return (
    <div
      class={`page ${phone ? "narrow" : "wide"} ${phase === "live" ? "" : "not-live"} ${stopped ? "stopped" : ""} ${replay ? "replay" : ""} ${mapped ? "mapped" : ""}`}
      data-testid="page"
      data-phase={phase}
    >
      <Skips />
      <TopBar narrow={phone} />
      <main class="view" aria-label="View">
        {store.scene.value ? <SceneView /> : <NoScene />}
        {mapped && <MapPanel place="view" />}
        {!(phone && mapped) && (
          <div class="insets">
            <Camera />
            {(!phone || store.around.value === "large") && <Around place="view" />}
          </div>
        )}
        <div class="view-tools">
          {audio && (audio.listen || replay) && <ListenButton />}
          {audio && (audio.speak || replay) && <TalkButton />}
          {body.maps && <MapToggle />}
          <SceneToggle />
        </div>
        <Banner />
        {!phone && !replay && body.drives && <DrivePad />}
      </main>
      {!phone && <Transport />}
      {!(phone && mapped) && <Side phone={phone} />}
      {!phone && <Lanes />}
      {phone && (
        <footer class={`dock ${body.drives || replay ? "" : "still"}`}>
          {replay ? (
            <Transport />
          ) : (
            <>
              {body.drives && <DrivePad />}
              <EStop />
            </>
          )}
        </footer>
      )}
      <Notices />
      <Help />
    </div>
  );
}

/** Where the camera's picture would be alone. */
function NoScene() {
  const { store } = useApp();
  const body = store.body.value;
  return (
    <div class="scene" data-testid="scene" data-state="off">
      {store.hello.value?.channels.camera === false && (
        <p class="scene-note">
          {store.replay.value ? "This recording has no pictures." : `This robot has no camera. See ${body.maps ? "its map, or " : ""}3D.`}
        </p>
      )}
    </div>
  );
}

function SceneToggle() {
  const { store } = useApp();
  const shown = store.scene.value;
  return (
    <button
      type="button"
      class="scene-toggle button small"
      data-testid="scene-toggle"
      aria-pressed={shown}
      title={shown ? "Hide the 3D view" : "Show the 3D view"}
      onClick={() => store.showScene(!shown)}
    >
      <CubeIcon /> <span class="tool-words">{shown ? "Hide 3D" : "Show 3D"}</span>
    </button>
  );
}

function MapToggle() {
  const { store } = useApp();
  const shown = store.mapPlace.value === "view";
  return (
    <button
      type="button"
      class={`tool-button button small ${shown ? "on" : ""}`}
      data-testid="map-toggle"
      aria-pressed={shown}
      title="The map over all of the view (M)"
      onClick={() => store.showMap(shown ? "tab" : "view")}
    >
      <MapIcon /> <span class="tool-words">Map</span>
    </button>
  );
}

function Side({ phone }: { phone: boolean }) {
  const { store, session } = useApp();
  const trouble =
    store.load.value?.modules.filter((module) => module.state === "failed" || module.state === "hung").length ?? 0;
  const items: TabItem[] = [
    {
      id: "attention",
      title: "Attention",
      content: () => (
        <>
          <Intention />
          <section class="card" aria-label="Desires">
            <h2>
              Desires <span class="count">{store.desires.value?.length ?? 0}</span>
            </h2>
            <DesireList />
            <DesireForm />
          </section>
        </>
      ),
    },
    {
      id: "found",
      title: "Found",
      badge: store.landmarks.value?.length ?? 0,
      content: () => (
        <>
          {phone && store.around.value !== "large" && <Around place="tab" />}
          <People />
          <Found />
        </>
      ),
    },
    { id: "load", title: "Load", ...(trouble > 0 ? { badge: "!", alarm: true } : {}), content: () => <Load /> },
    { id: "events", title: "Events", content: () => <Events /> },
  ];
  if (!store.replay.value) {
    const alarm = store.recorder.value?.state === "stopped";
    items.push({ id: "recordings", title: "Recordings", alarm, content: () => <Recordings /> });
  }
  if (store.body.value.maps) items.splice(1, 0, { id: "map", title: "Map", content: () => <MapTab /> });
  if (phone) items.splice(items.findIndex(({ id }) => id === "found"), 0, { id: "lanes", title: "Lanes", content: () => <Lanes /> });
  items.push(...externalTabs({ session, store }));
  return <Tabs items={items} />;
}

function MapTab() {
  const { store } = useApp();
  return (
    <>
      {store.mapPlace.value === "tab" && <MapPanel place="tab" />}
      <Zones />
      {!store.replay.value && <Maps />}
    </>
  );
}
