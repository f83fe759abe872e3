/** Everything around the robot on one strip: the panorama's picture, who is seen, what is heard, and from where. */

import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { useApp } from "../state/context";
import { number } from "../ui/format";
import { AroundIcon, CloseIcon, EnlargeIcon, ShrinkIcon } from "../ui/icons";
import { draw } from "./drawAround";
import { faceMarks, flash, soundMarks, summary } from "./perceptMarks";
import { SHAPE, type Strip } from "./stripProjection";
import { type Closed, perceives, whyClosed } from "./whyClosed";

const OLD_S = 1.5;
const FADE_STEP_MS = 60;

/** `tab`: on a phone, among what was found. */
export function Around({ place }: { place: "view" | "tab" }) {
  const { store } = useApp();
  const mode = store.around.value;
  if (!perceives(store.hello.value)) return null;
  if (mode === "hidden")
    return (
      <button
        type="button"
        class="around-show button"
        data-testid="around-show"
        onClick={() => store.showAround("inset")}
      >
        <AroundIcon /> Around
      </button>
    );
  return <Sphere place={place} large={mode === "large"} />;
}

function Sphere({ place, large }: { place: "view" | "tab"; large: boolean }) {
  const { store, panorama } = useApp();
  const canvas = useRef<HTMLCanvasElement>(null);
  const paintOn = usePainter();
  useEffect(() => paintOn(canvas.current!, large), [large]);

  const { perceived, now, fresh, closed } = useAround();
  const faces = faceMarks(perceived);
  const sounds = soundMarks(perceived, now);
  const told = summary(faces, sounds, flash(perceived, now) > 0);
  const empty = faces.length === 0 && sounds.length === 0;
  const blank = empty && panorama.stamp.value === null;
  const words = told || "Nobody seen, nothing heard";
  const age = panorama.stamp.value === null ? null : now - panorama.stamp.value;
  return (
    <figure
      class={`around in-${place} ${large ? "large" : "inset"} ${blank ? "blank" : ""}`}
      data-testid="around"
      data-stamp={panorama.stamp.value ?? ""}
      data-summary={words}
      aria-label="Around the robot"
    >
      <div class="around-strip">
        <canvas ref={canvas} role="img" aria-label={`Around the robot: ${words}`} />
        {blank && <Nothing closed={closed} />}
        {!fresh && age !== null && (
          <span class="around-age" data-testid="around-age">
            {age > 0 ? `${number(age, age < 10 ? 1 : 0)} s old` : "old"}
          </span>
        )}
      </div>
      <figcaption data-testid="around-text">
        <span class={told ? "around-told" : "around-told muted"}>{words}</span>
        {!blank && closed.length > 0 && (
          <span class="around-closed" title={closed.map(titleOf).join("\n")}>
            {closed.map(({ text }) => text).join(" · ")}
          </span>
        )}
      </figcaption>
      <div class="camera-tools">
        <button
          type="button"
          class="icon-button"
          data-testid="around-enlarge"
          aria-label={large ? "Shrink the view all around" : "Enlarge the view all around"}
          aria-pressed={large}
          onClick={() => store.showAround(large ? "inset" : "large")}
        >
          {large ? <ShrinkIcon /> : <EnlargeIcon />}
        </button>
        <button
          type="button"
          class="icon-button"
          data-testid="around-hide"
          aria-label="Hide the view all around"
          onClick={() => store.showAround("hidden")}
        >
          <CloseIcon />
        </button>
      </div>
      <ul class="visually-hidden">
        {faces.map((face) => (
          <li
            key={face.track}
            data-testid="around-face"
            data-track={face.track}
            data-azimuth={face.azimuth}
            data-elevation={face.elevation}
            data-range={face.range ?? ""}
          >
            {face.text}
          </li>
        ))}
        {sounds.map((sound) => (
          <li
            key={sound.track}
            data-testid="around-sound"
            data-track={sound.track}
            data-azimuth={sound.azimuth}
            data-elevation={sound.elevation}
            data-kind={sound.kind}
            data-active={sound.active}
          >
            {sound.text}
          </li>
        ))}
      </ul>
    </figure>
  );
}

/** What is known of all around, and why it is not more. */
function useAround() {
  const { store, panorama } = useApp();
  const perceived = store.of("perceived").value;
  const now = store.now.value ?? perceived?.stamp ?? 0;
  const stamp = panorama.stamp.value;
  const fresh = stamp !== null && now - stamp <= OLD_S * Math.max(1, store.clock.rate);
  const closed = whyClosed(store.hello.value, store.rows.value, store.replay.value, fresh);
  return { perceived, now, fresh, closed };
}

function Nothing({ closed }: { closed: Closed[] }) {
  return (
    <div class="around-nothing" data-testid="around-nothing">
      <p>Nobody seen, nothing heard yet.</p>
      {closed.map((one) => (
        <p key={one.what} class="muted" title={one.reason}>
          {one.reason ? `${one.text}: ${one.reason}` : `${one.text}.`}
        </p>
      ))}
    </div>
  );
}

function titleOf({ text, reason }: Closed): string {
  return reason ? `${text}: ${reason}` : text;
}

/** Paints on every change, and while something fades; returns what ends it. */
function usePainter() {
  const { store, panorama } = useApp();
  return (canvas: HTMLCanvasElement, large: boolean) => {
    let timer = 0;
    let strip: Strip = { width: 0, height: 0 };
    const paint = () => {
      clearTimeout(timer);
      if (strip.width < 1) return;
      const perceived = store.of("perceived").peek();
      const now = store.clock.now(performance.now() / 1000) ?? perceived?.stamp ?? 0;
      const stamp = panorama.stamp.peek();
      const sounds = soundMarks(perceived, now);
      const left = flash(perceived, now);
      const context = canvas.getContext("2d")!;
      const density = canvas.width / strip.width;
      context.setTransform(density, 0, 0, density, 0, 0);
      draw(context, strip, {
        picture: stamp === null ? null : panorama.canvas,
        old: stamp !== null && now - stamp > OLD_S * Math.max(1, store.clock.rate),
        faces: faceMarks(perceived),
        sounds,
        flash: left,
        large,
      });
      if (left > 0 || sounds.some((sound) => !sound.active)) timer = window.setTimeout(later, FADE_STEP_MS);
    };
    const later = () => requestAnimationFrame(paint);
    const sized = new ResizeObserver(() => {
      const width = canvas.clientWidth;
      strip = { width, height: width / SHAPE };
      const density = Math.min(2, window.devicePixelRatio || 1);
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(strip.height * density);
      paint();
    });
    sized.observe(canvas);
    const end = effect(() => {
      void store.of("perceived").value;
      void panorama.stamp.value;
      void store.seconds.value;
      paint();
    });
    return () => {
      end();
      sized.disconnect();
      clearTimeout(timer);
    };
  };
}
