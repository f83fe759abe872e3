/** The 3D view: viser in a frame of our own origin. Its keys drive too, and it never keeps the keyboard for itself. */

import { useEffect, useRef, useState } from "preact/hooks";
import { useApp } from "../state/context";
import { hopeless, paced, SHARES, startPace } from "./pace";

type Scene = "loading" | "shown" | "missing";

export function SceneView() {
  const { store, drive, talking, map } = useApp();
  const frame = useRef<HTMLIFrameElement>(null);
  const [scene, setScene] = useState<Scene>("loading");
  const [step, setStep] = useState(0);
  const warned = useRef(false);
  const live = store.live.value;
  useEffect(() => {
    if (scene !== "shown" || new URLSearchParams(location.search).get("scene") === "full") return;
    let pace = startPace(performance.now(), step);
    let request = requestAnimationFrame(function frame(now) {
      pace = document.hidden ? startPace(now, pace.step) : paced(pace, now);
      if (hopeless(pace) && !warned.current) {
        warned.current = true;
        store.notify("info", "The 3D view is slow on this computer. Hide it for smoother driving.");
      }
      if (pace.step !== step) setStep(pace.step);
      else request = requestAnimationFrame(frame);
    });
    return () => cancelAnimationFrame(request);
  }, [scene, step]);

  const loaded = () => {
    const inner = pageOf(frame.current);
    if (inner?.document.contentType !== "text/html") {
      setScene("missing");
      return;
    }
    setScene("shown");
    keepReconnecting(inner);
    dress(inner.document);
    map.listenIn(inner);
    drive.listenIn(inner);
    talking.listenIn(inner);
  };
  const reload = () => {
    setScene("loading");
    frame.current?.contentWindow?.location.reload();
  };

  useEffect(() => {
    if (!live) return;
    if (scene === "missing") frame.current!.src = "./viser/";
    else pageOf(frame.current)?.dispatchEvent(new Event("focus"));
  }, [live]);

  return (
    <div
      class="scene"
      data-testid="scene"
      data-state={scene}
      data-share={SHARES[step]}
      onPointerLeave={() => drive.state.peek().command.held || takeKeyboardBack(frame.current)}
    >
      <iframe
        ref={frame}
        src="./viser/"
        title="3D view of the robot and what it perceives"
        onLoad={loaded}
        tabIndex={-1}
        style={shrunk(SHARES[step]!)}
      />
      {scene === "shown" && <SceneLegend />}
      {scene === "loading" && <p class="scene-note">Loading the 3D view…</p>}
      {scene === "missing" && (
        <div class="scene-note">
          <p>The 3D view does not answer.</p>
          <button type="button" class="button" onClick={reload}>
            Try again
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
  if (!(scans || places || faces || voices)) return null;
  return (
    <ul class="scene-legend" data-testid="scene-legend" aria-label="Colours of the 3D view">
      {scans && (
        <li>
          laser: near
          <i class="laser-colors" />
          far
        </li>
      )}
      {places && (
        <li>
          <i class="poster-color" />
          QR code found
        </li>
      )}
      {faces && (
        <li>
          <i class="face-color" />
          person seen
        </li>
      )}
      {voices && (
        <li>
          <i class="sound-color voice" />
          voice
          <i class="sound-color" />
          other sound
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

function pageOf(frame: HTMLIFrameElement | null): (Window & typeof globalThis) | null {
  try {
    const inner = frame?.contentWindow as (Window & typeof globalThis) | null | undefined;
    return inner?.document ? inner : null;
  } catch {
    return null; // the browser's own error page is of another origin
  }
}

/** viser reconnects only while its document has the focus, which a frame beside ours seldom has. */
function keepReconnecting(inner: Window): void {
  inner.document.hasFocus = () => true;
  inner.dispatchEvent(new Event("focus"));
}

/**
 * What viser shows over its scene and the page has no room for: its notices, which lie under the camera picture, and on
 * a phone its panel, which would cover the scene (it is drawn with these inline styles and has no name).
 */
const DRESS = `
  .mantine-Notifications-root { display: none !important; }
  [style*="position: fixed"][style*="width: 20em"][style*="max-height: 60%"] { display: none !important; }
`;

function dress(page: Document): void {
  const style = page.createElement("style");
  style.textContent = DRESS;
  page.head.append(style);
}

/** When the pointer leaves the view, the keyboard comes back to the page, unless something is typed over there. */
function takeKeyboardBack(frame: HTMLIFrameElement | null): void {
  if (!frame || document.activeElement !== frame) return;
  const typing = pageOf(frame)?.document.activeElement?.matches("input, textarea");
  if (typing) return;
  frame.blur();
  document.querySelector<HTMLElement>("[data-testid=stick]")?.focus({ preventScroll: true });
}
