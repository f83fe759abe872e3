/** What the robot sees: the camera picture over the 3D view, its age when it is old, and why there is none. */

import { useEffect, useRef } from "preact/hooks";
import { useApp } from "../state/context";
import { number, reasonText } from "../ui/format";
import { CameraIcon, CloseIcon, EnlargeIcon, ShrinkIcon } from "../ui/icons";
import { pictureShare } from "./pictureShare";
import { OVERLAYS } from "./registry";

const OLD_S = 1;
/** The desire class whose filters let the camera through to people. */
const CLASS = "Telepresence";

export function Camera() {
  const { store, camera, drive, tourPointing } = useApp();
  const canvas = useRef<HTMLCanvasElement>(null);
  const mode = store.camera.value;
  useEffect(() => {
    camera.canvas = canvas.current;
    return () => {
      camera.canvas = null;
    };
  }, [mode]);

  if (store.hello.value?.channels.camera === false) return null; // nothing to show, nothing to cover
  if (mode === "hidden") {
    return (
      <button
        type="button"
        class="camera-show button"
        data-testid="camera-show"
        onClick={() => store.showCamera("inset")}
      >
        <CameraIcon /> Camera
      </button>
    );
  }
  const { text, old, empty } = useCameraState();
  const large = mode === "large";
  const live = !empty && !store.replay.value && camera.stamp.value !== null;
  const points = live && tourPointing.target.value !== null;
  const looks = live && store.body.value.turnsHead;
  return (
    <figure
      class={`camera ${mode} ${old ? "old" : ""} ${empty ? "empty" : ""}`}
      data-testid="camera"
      data-stamp={camera.stamp.value ?? ""}
      aria-label="Camera picture"
    >
      <canvas
        ref={canvas}
        class={looks || points ? "looks" : ""}
        width={640}
        height={480}
        role="img"
        aria-label={empty ? text : "What the robot's camera sees"}
        title={points ? "Click: the point of the step" : looks ? "Click: the head turns there" : undefined}
        onClick={(event) => {
          const at = (looks || points) && placeOn(event.currentTarget, event);
          if (at && points) void tourPointing.picture(camera.stamp.peek()!, at.u, at.v);
          else if (at) drive.lookHere(camera.stamp.peek()!, at.u, at.v);
        }}
      />
      {!empty && OVERLAYS.map(({ type, Frames }) => <Frames key={type} message={store.of(type).value} />)}
      {text && (
        <figcaption class={empty ? "camera-empty" : "camera-age"} data-testid="camera-text">
          {empty && <CameraIcon />}
          <span>{text}</span>
        </figcaption>
      )}
      <div class="camera-tools">
        <button
          type="button"
          class="icon-button"
          data-testid="camera-enlarge"
          aria-label={large ? "Shrink the camera picture" : "Enlarge the camera picture"}
          aria-pressed={large}
          onClick={() => store.showCamera(large ? "inset" : "large")}
        >
          {large ? <ShrinkIcon /> : <EnlargeIcon />}
        </button>
        <button
          type="button"
          class="icon-button"
          data-testid="camera-hide"
          aria-label="Hide the camera picture"
          onClick={() => store.showCamera("hidden")}
        >
          <CloseIcon />
        </button>
      </div>
    </figure>
  );
}

/** Where a click is in the picture, which is drawn as large as the canvas allows, in its middle; null: beside it. */
function placeOn(canvas: HTMLCanvasElement, event: MouseEvent): { u: number; v: number } | null {
  const box = canvas.getBoundingClientRect();
  const at = pictureShare(box, canvas, event.clientX - box.left, event.clientY - box.top);
  return at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1 ? at : null;
}

function useCameraState(): { text: string; old: boolean; empty: boolean } {
  const { store, camera } = useApp();
  const stamp = camera.stamp.value;
  const now = store.now.value;
  const lane = store.rows.value.find((row) => row.class === CLASS);
  const age = stamp !== null && now !== null ? now - stamp : null;
  const old = age !== null && age > OLD_S * Math.max(1, store.clock.rate);
  if (lane && lane.divisor === null && (age === null || old))
    return { text: `No picture. ${reasonText(lane.state, lane.text)}`, old, empty: true };
  if (age === null && store.replay.value)
    return { text: "No picture yet at this time of the recording.", old: false, empty: true };
  if (age === null)
    return { text: store.live.value ? "Waiting for the first picture…" : "No picture yet.", old: false, empty: true };
  return { text: old ? `${number(age, 1)} s old` : "", old, empty: false };
}
