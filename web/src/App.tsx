/** The page: bar, view, side, lanes; stacked on a phone. */

import { Around } from "./around/Around";
import { DrivePad } from "./drive/DrivePad";
import { t } from "./i18n";
import { Lanes } from "./lanes/Lanes";
import { LanesSplitter, SideSplitter } from "./layout/Splitter";
import { MapPanel } from "./map/MapPanel";
import { Side } from "./panels/Side";
import { Transport } from "./playback/Transport";
import { ListenButton } from "./sound/ListenButton";
import { TalkButton } from "./sound/TalkButton";
import { SayButton } from "./speech/SayBox";
import { Subtitles } from "./speech/Subtitles";
import { useApp } from "./state/context";
import { PosterPicked } from "./tours/PosterPicked";
import { TourDriveBanner } from "./tours/TourDriveBanner";
import { Banner } from "./ui/Banner";
import { EStop } from "./ui/EStop";
import { Help } from "./ui/Help";
import { CubeIcon, MapIcon, TourIcon } from "./ui/icons";
import { Login } from "./ui/Login";
import { low, narrow } from "./ui/media";
import { Notices } from "./ui/Notices";
import { Skips } from "./ui/Skips";
import { TopBar } from "./ui/TopBar";
import { Camera } from "./view/Camera";
import { SceneView } from "./view/SceneView";

export function App() {
  const { layout, store } = useApp();
  const phase = store.link.value.phase;
  if (phase === "login") return <Login />;
  const phone = narrow.value;
  const replay = store.replay.value;
  const stopped = store.stopped.value && !replay;
  const body = store.body.value;
  const mapped = body.maps && store.mapPlace.value === "view";
  const { side, lanes, sideShown, lanesShown, edge, lanesAt } = layout.layout.value;
  const below = !phone && lanesShown && !low.value; // so low, the lanes have their tab
  const divided = `${sideShown ? "" : "no-side"} ${below ? "" : "no-lanes"} side-${edge} lanes-${lanesAt}`;
  // What a body cannot do is not offered; on a recording the button says why it is off.
  const audio = store.hello.value?.audio;
  return (
    <div
      class={`page ${phone ? "narrow" : "wide"} ${phase === "live" ? "" : "not-live"} ${stopped ? "stopped" : ""} ${replay ? "replay" : ""} ${mapped ? "mapped" : ""} ${phone ? "" : divided}`}
      style={{ "--side": side, "--lanes": lanes }}
      data-testid="page"
      data-phase={phase}
    >
      <Skips />
      <TopBar narrow={phone} />
      <main class="view" aria-label={t("View")}>
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
          {!phone && <SayButton />}
          {body.maps && <MapToggle />}
          {body.maps && !replay && !phone && <TourToggle />}
          <SceneToggle />
        </div>
        <Subtitles />
        <TourDriveBanner />
        <PosterPicked />
        <Banner />
        {!phone && !replay && body.drives && <DrivePad />}
      </main>
      {!phone && <Transport />}
      {(phone ? !mapped : sideShown) && <Side phone={phone} />}
      {!phone && sideShown && <SideSplitter />}
      {below && <Lanes />}
      {below && <LanesSplitter />}
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
          {store.replay.value
            ? t("This recording has no pictures.")
            : body.maps
              ? t("This robot has no camera. See its map, or 3D.")
              : t("This robot has no camera. See 3D.")}
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
      title={shown ? t("Hide the 3D view") : t("Show the 3D view")}
      onClick={() => store.showScene(!shown)}
    >
      <CubeIcon /> <span class="tool-words">3D</span>
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
      title={t("Map over the whole view (M)")}
      onClick={() => store.showMap(shown ? "tab" : "view")}
    >
      <MapIcon /> <span class="tool-words">{t("Map")}</span>
    </button>
  );
}

/** The map large and the stops beside it. A phone has the tab. */
function TourToggle() {
  const { store } = useApp();
  const shown = store.tab.value === "tour" && store.mapPlace.value === "view";
  return (
    <button
      type="button"
      class={`tool-button button small ${shown ? "on" : ""}`}
      data-testid="tour-toggle"
      aria-pressed={shown}
      title={t("Edit tours: the map large, the stops beside it")}
      onClick={() => store.showTour("view")}
    >
      <TourIcon /> <span class="tool-words">{t("Tour")}</span>
    </button>
  );
}
