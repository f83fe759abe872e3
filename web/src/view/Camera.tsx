/** What the robot sees: the camera picture over the 3D view, its age, and why there is none. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import { useApp } from "../state/context";
import { reasonText } from "../ui/format";
import { CameraIcon, CloseIcon, EnlargeIcon, FlagIcon, ShrinkIcon } from "../ui/icons";
import { goalFor } from "./clickToGo";
import { isOld, pictureAge } from "./pictureAge";
import { pictureShare } from "./pictureShare";
import { OVERLAYS } from "./registry";

/** The desire class whose filters let the camera through to people. */
const CLASS = "Telepresence";

export function Camera() {
  const { store, session, camera, drive, map, tourPointing } = useApp();
  /** The next click is a goal. */
  const asksGoal = useSignal(false);
  const canvas = useRef<HTMLCanvasElement>(null);
  const mode = store.camera.value;
  const there = mode !== "hidden" && store.hello.value?.channels.camera !== false;
  useEffect(() => (there ? camera.show(canvas.current!) : undefined), [there]);

  if (store.hello.value?.channels.camera === false) return null; // nothing to show, nothing to cover
  if (mode === "hidden") {
    return (
      <button
        type="button"
        class="camera-show button"
        data-testid="camera-show"
        onClick={() => store.showCamera("inset")}
      >
        <CameraIcon /> {t("Camera")}
      </button>
    );
  }
  const { text, old, empty } = useCameraState();
  const large = mode === "large";
  const live = !empty && !store.replay.value && camera.stamp.value !== null;
  const points = live && tourPointing.target.value !== null;
  const looks = live && store.body.value.turnsHead;
  const goes = live && store.body.value.goes && store.body.value.maps;
  const goTo = async (stamp: number, u: number, v: number) => {
    asksGoal.value = false;
    try {
      const robot = store.of("localization").peek();
      const point = await session.rest.cameraPoint({ stamp, u, v });
      const goal = robot && goalFor(point, robot);
      if (goal) await map.goTo(goal.x, goal.y, goal.heading);
      else store.notify("info", t("The robot is there already."));
    } catch (error) {
      store.notify("error", inWords(error));
    }
  };
  return (
    <figure
      class={`camera ${mode} ${old ? "old" : ""} ${empty ? "empty" : ""}`}
      data-testid="camera"
      data-stamp={camera.stamp.value ?? ""}
      data-coding={camera.coding.value}
      aria-label={t("Camera picture")}
    >
      <canvas
        ref={canvas}
        class={asksGoal.value ? "goes" : looks || points ? "looks" : ""}
        width={640}
        height={480}
        role="img"
        aria-label={empty ? text : t("What the robot's camera sees")}
        title={
          points
            ? t("Click: the point of the step")
            : asksGoal.value
              ? t("Click: the robot goes there")
              : looks
                ? goes
                  ? t("Click: the head turns there; with Shift, the robot goes there")
                  : t("Click: the head turns there")
                : undefined
        }
        onClick={(event) => {
          const at = placeOn(event.currentTarget, camera.size, event);
          const wantsGoal = goes && !points && (asksGoal.peek() || event.shiftKey);
          if (at && wantsGoal) void goTo(camera.stamp.peek()!, at.u, at.v);
          else if (!(looks || points)) return;
          else if (at && points) void tourPointing.picture(camera.stamp.peek()!, at.u, at.v);
          else if (at) drive.lookHere(camera.stamp.peek()!, at.u, at.v);
        }}
      />
      {!empty && OVERLAYS.map(({ type, Frames }) => <Frames key={type} message={store.of(type).value} />)}
      {empty ? (
        <figcaption class="camera-empty" data-testid="camera-text">
          <CameraIcon />
          <span>{text}</span>
        </figcaption>
      ) : (
        <Age />
      )}
      <div class="camera-tools">
        {goes && (
          <button
            type="button"
            class={`icon-button ${asksGoal.value ? "on" : ""}`}
            data-testid="camera-go"
            aria-label={t("Go to a point of the picture")}
            aria-pressed={asksGoal.value}
            title={t("Then click in the picture: the robot goes there (or Shift and a click)")}
            onClick={() => (asksGoal.value = !asksGoal.value)}
          >
            <FlagIcon />
          </button>
        )}
        <button
          type="button"
          class="icon-button"
          data-testid="camera-enlarge"
          aria-label={large ? t("Shrink the camera picture") : t("Enlarge the camera picture")}
          aria-pressed={large}
          onClick={() => store.showCamera(large ? "inset" : "large")}
        >
          {large ? <ShrinkIcon /> : <EnlargeIcon />}
        </button>
        <button
          type="button"
          class="icon-button"
          data-testid="camera-hide"
          aria-label={t("Hide the camera picture")}
          onClick={() => store.showCamera("hidden")}
        >
          <CloseIcon />
        </button>
      </div>
    </figure>
  );
}

/**
 * Refreshed as the robot's clock is, four times a second: digits that change with every picture could not be read. In a
 * recording that is paused the clock rests, and the picture of another place comes after it.
 */
function Age() {
  const { store, camera } = useApp();
  const now = store.now.value;
  const stamp = store.replay.value ? camera.stamp.value : camera.stamp.peek();
  if (now === null || stamp === null) return null;
  const shown = pictureAge(now - stamp, store.clock.rate, store.replay.value);
  if (shown === null) return null;
  return (
    <figcaption class={`camera-age ${shown.late ? "late" : ""}`} data-testid="camera-age" title={shown.title}>
      {shown.text}
    </figcaption>
  );
}

/** Where a click is in the picture, which is drawn as large as the canvas allows, in its middle; null: beside it. */
function placeOn(
  canvas: HTMLCanvasElement,
  picture: { width: number; height: number },
  event: MouseEvent,
): { u: number; v: number } | null {
  const box = canvas.getBoundingClientRect();
  const at = pictureShare(box, picture, event.clientX - box.left, event.clientY - box.top);
  return at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1 ? at : null;
}

function useCameraState(): { text: string; old: boolean; empty: boolean } {
  const { store, camera } = useApp();
  const stamp = camera.stamp.value;
  const now = store.now.value;
  const lane = store.rows.value.find((row) => row.class === CLASS);
  const age = stamp !== null && now !== null ? now - stamp : null;
  const old = age !== null && isOld(age, store.clock.rate);
  if (lane && lane.divisor === null && (age === null || old))
    return { text: t("No picture. {reason}", { reason: reasonText(lane.state, lane.text) }), old, empty: true };
  if (age === null && store.replay.value)
    return { text: t("No picture yet at this time of the recording."), old: false, empty: true };
  if (age === null)
    return {
      text: store.live.value ? t("Waiting for the first picture…") : t("No picture yet."),
      old: false,
      empty: true,
    };
  return { text: "", old, empty: false };
}
