/** The 3D view: viser in a frame. Its keys drive too, and it never keeps the keyboard for itself. */

import { useSignalEffect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { FollowControl } from "../drive/followControl";
import { DRIVE_KEYS, HEAD_KEYS, STRAFE_KEYS } from "../drive/keys";
import { rich, t } from "../i18n";
import { PLAYBACK_KEYS } from "../playback/transport";
import { useApp } from "../state/context";
import type { Store } from "../state/store";
import { FULL, hopeless, paced, SHARES } from "./pace";
import { PointHint, ScenePicked } from "./ScenePicked";
import { sceneAddress } from "./sceneAddress";
import { SceneFrame } from "./sceneFrame";
import type { Stroke } from "./sceneMessages";
import { ScenePicking } from "./scenePicking";
import { ViewpointStrip } from "./ViewpointStrip";
import { VIEW_KEYS } from "./viewpoints";

export function SceneView() {
  const { store, session, drive, tourPointing } = useApp();
  const [follow] = useState(() => new FollowControl(drive));
  const frame = useRef<HTMLIFrameElement>(null);
  const [pace, setPace] = useState(FULL);
  const [picking] = useState(() => new ScenePicking(store, session.rest, tourPointing));
  const [scene] = useState(() => {
    const own = new URL("./viser/", location.href).href;
    const whole = new URLSearchParams(location.search).get("scene") === "full";
    return new SceneFrame({
      own,
      find: () => sceneAddress(session.rest, own, isSecureContext),
      inner: () => frame.current?.contentWindow ?? null,
      strike: (stroke) => strike(frame.current ?? window, stroke),
      frames: (ms) => {
        if (!whole) setPace((before) => paced(before, ms));
      },
    });
  });
  const share = SHARES[pace.step]!;
  const live = store.live.value;
  const state = scene.state.value;
  const address = scene.address.value;

  useEffect(() => {
    const receive = (event: MessageEvent) => scene.receive(event);
    const takeBack = () => void window.setTimeout(() => takeKeyboardBack(frame.current));
    window.addEventListener("message", receive);
    window.addEventListener("blur", takeBack);
    return () => {
      window.removeEventListener("message", receive);
      window.removeEventListener("blur", takeBack);
      scene.close();
      follow.stop();
      picking.close();
      store.softLimit.value = null;
      store.sceneShown.value = false;
    };
  }, []);
  useEffect(() => {
    scene.onHand = (down) => {
      follow.hand(down);
      picking.close();
    };
    scene.onPicked = (click) => void picking.click(click);
    scene.onCamera = (camera) => follow.look(camera);
  }, []);
  useSignalEffect(() => void (store.sceneShown.value = scene.state.value === "shown"));
  useSignalEffect(() => scene.takeKeys(keysOfPage(store)));
  useSignalEffect(() => {
    scene.drives(drive.holding.value);
    if (drive.holding.value) picking.close(); // the robot moves, and the view with it: its pin would lie elsewhere
  });
  useSignalEffect(() => void (store.softLimit.value = follow.softLimit.value));
  useSignalEffect(() => scene.limits(follow.softLimit.value?.angle ?? null));
  useEffect(() => {
    if (live) void scene.answered(); // not before the login
  }, [live]);
  const slow = hopeless(pace);
  useEffect(() => {
    if (slow) store.notify("info", t("The 3D view is slow on this computer. Hide it for smoother driving."));
  }, [slow]);

  return (
    <div class="scene" data-testid="scene" data-state={state} data-share={share}>
      {address !== null && (
        <iframe
          key={scene.load.value}
          ref={frame}
          src={address}
          title={t("3D view of the robot and what it perceives")}
          onLoad={() => scene.loaded()}
          tabIndex={-1}
          style={shrunk(share)}
        />
      )}
      {state === "shown" && <ViewpointStrip scene={scene} follow={follow} />}
      {state === "shown" && <SceneLegend />}
      {state === "shown" && <ScenePicked picking={picking} />}
      {state === "shown" && <PointHint />}
      {state === "loading" && <p class="scene-note">{t("Loading the 3D view…")}</p>}
      {state === "missing" && (
        <div class="scene-note">
          <p>{t("The 3D view does not answer.")}</p>
          <button type="button" class="button" onClick={() => void scene.open()}>
            {t("Try again")}
          </button>
        </div>
      )}
    </div>
  );
}

/** What the colours in the view mean; as drawn by the console's view. */
function SceneLegend() {
  const { store } = useApp();
  const { scans, places, faces, voices } = store.body.value;
  const follows = store.softLimit.value !== null;
  if (!(scans || places || faces || voices || follows)) return null;
  return (
    <ul class="scene-legend" data-testid="scene-legend" aria-label={t("Colours of the 3D view")}>
      {scans && <li>{rich("laser: near {colors} far", { colors: <i class="laser-colors" /> })}</li>}
      {places && (
        <li>
          <i class="poster-color" />
          {t("QR code found")}
        </li>
      )}
      {faces && (
        <li>
          <i class="face-color" />
          {t("person seen")}
        </li>
      )}
      {voices && (
        <li>
          <i class="sound-color voice" />
          {t("voice")}
          <i class="sound-color" />
          {t("other sound")}
        </li>
      )}
      {follows && (
        <li>
          <i class="limit-color" />
          {t("the head turns alone")}
        </li>
      )}
    </ul>
  );
}

/** Drawn at `share` of the resolution, shown at the full size. */
function shrunk(share: number): Record<string, string> {
  if (share === 1) return {};
  return {
    width: `${100 * share}%`,
    height: `${100 * share}%`,
    transform: `scale(${1 / share})`,
    transformOrigin: "0 0",
  };
}

/** The keys that viser, which moves its camera by some of them, is kept from. */
function keysOfPage(store: Store): string[] {
  if (store.replay.value) return [...PLAYBACK_KEYS, ...VIEW_KEYS];
  const { drives, strafes, turnsHead } = store.body.value;
  if (!drives) return ["Space", ...VIEW_KEYS];
  return ["Space", ...VIEW_KEYS, ...DRIVE_KEYS, ...(strafes ? STRAFE_KEYS : []), ...(turnsHead ? HEAD_KEYS : [])];
}

/** A key of the frame, as one of the page pressed on the frame. */
function strike(target: EventTarget, { down, code, key, repeat, ctrlKey, altKey, metaKey, shiftKey }: Stroke): void {
  const held = { ctrlKey, altKey, metaKey, shiftKey };
  const event = { code, key, repeat, ...held, bubbles: true, cancelable: true };
  target.dispatchEvent(new KeyboardEvent(down ? "keydown" : "keyup", event));
}

/**
 * A click into the frame gives it the keyboard. The page has it back at once: keys need no way through the frame's
 * process, which may be busy drawing.
 */
function takeKeyboardBack(frame: HTMLIFrameElement | null): void {
  if (!frame || document.activeElement !== frame || !document.hasFocus()) return;
  frame.blur();
  window.focus();
  document.querySelector<HTMLElement>("[data-testid=stick]")?.focus({ preventScroll: true });
}
