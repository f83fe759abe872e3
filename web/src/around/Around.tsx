/** Everything around the robot on one strip: the panorama's picture, who is seen, what is heard, and from where. */

import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { useApp } from "../state/context";
import type { Store } from "../state/store";
import { AroundIcon, CloseIcon, EnlargeIcon, SalientIcon, ShrinkIcon } from "../ui/icons";
import { pictureAge } from "../view/pictureAge";
import { draw } from "./drawAround";
import type { Box, Layer } from "./layer";
import { LAYERS } from "./registry";
import { fresh as isFresh } from "./saliencyMarks";
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
        <AroundIcon /> {t("Around")}
      </button>
    );
  return <Sphere place={place} large={mode === "large"} />;
}

function Sphere({ place, large }: { place: "view" | "tab"; large: boolean }) {
  const { store, panorama } = useApp();
  const canvas = useRef<HTMLCanvasElement>(null);
  const paintOn = usePainter();
  useEffect(() => paintOn(canvas.current!, large), [large]);

  const { now, fresh, closed } = useAround();
  const layers = layersOf(store);
  const salient = isFresh(store.of("salient_regions").value, now);
  const seen = layers
    .map((layer) => layer.words(store.of(layer.type).value, now))
    .filter(Boolean)
    .join(", ");
  const blank = seen === "" && panorama.stamp.value === null;
  const words = seen || t("No people seen, no sounds heard");
  const stamp = panorama.stamp.value;
  const shown = stamp === null ? null : pictureAge(now - stamp, store.clock.rate, store.replay.value);
  return (
    <figure
      class={`around in-${place} ${large ? "large" : "inset"} ${blank ? "blank" : ""}`}
      data-testid="around"
      data-stamp={panorama.stamp.value ?? ""}
      data-summary={words}
      aria-label={t("Around the robot")}
    >
      <div class="around-strip">
        <canvas
          ref={canvas}
          role="img"
          aria-label={t("Around the robot: {words}", { words })}
          onPointerMove={(event) => showHover(event.currentTarget, event, store, layers)}
        />
        {blank && <Nothing closed={closed} large={large} />}
        {shown && (
          <span class={`around-age ${fresh ? "" : "old"}`} data-testid="around-age" title={shown.title}>
            {shown.text}
          </span>
        )}
      </div>
      <figcaption data-testid="around-text">
        <span class={seen ? "around-seen" : "around-seen muted"}>{words}</span>
        {!blank && closed.length > 0 && (
          <span class="around-closed" title={closed.map(titleOf).join("\n")}>
            {closed.map(({ text }) => text).join(" · ")}
          </span>
        )}
      </figcaption>
      <div class="camera-tools">
        {salient && (
          <button
            type="button"
            class="icon-button toggle"
            data-testid="around-salient"
            aria-label={store.salient.value ? t("Hide what stands out") : t("Show what stands out")}
            aria-pressed={store.salient.value}
            onClick={() => {
              store.salient.value = !store.salient.value;
            }}
          >
            <SalientIcon />
          </button>
        )}
        <button
          type="button"
          class="icon-button"
          data-testid="around-enlarge"
          aria-label={large ? t("Shrink the panorama") : t("Enlarge the panorama")}
          aria-pressed={large}
          onClick={() => store.showAround(large ? "inset" : "large")}
        >
          {large ? <ShrinkIcon /> : <EnlargeIcon />}
        </button>
        <button
          type="button"
          class="icon-button"
          data-testid="around-hide"
          aria-label={t("Hide the panorama")}
          onClick={() => store.showAround("hidden")}
        >
          <CloseIcon />
        </button>
      </div>
      <ul class="visually-hidden">
        {layers.map((layer) => (
          <layer.Marks key={layer.type} message={store.of(layer.type).value} now={now} />
        ))}
      </ul>
    </figure>
  );
}

/** The layers that are shown. */
function layersOf(store: Store): readonly Layer[] {
  return LAYERS.filter(({ group }) => group === undefined || store[group].value);
}

/** Words on what the pointer is over, as the canvas's title. */
function showHover(canvas: HTMLCanvasElement, event: PointerEvent, store: Store, layers: readonly Layer[]): void {
  const strip = { width: canvas.clientWidth, height: canvas.clientWidth / SHAPE };
  const at = { x: event.offsetX, y: event.offsetY };
  const now = store.now.peek() ?? 0;
  canvas.title = layers
    .map((layer) => layer.hover?.(strip, at, store.of(layer.type).peek(), now) ?? "")
    .filter(Boolean)
    .join("\n");
}

/** What is known of all around, and why it is not more. */
function useAround() {
  const { store, panorama } = useApp();
  const now = store.now.value ?? 0;
  const stamp = panorama.stamp.value;
  const fresh = stamp !== null && now - stamp <= OLD_S * Math.max(1, store.clock.rate);
  const closed = whyClosed(store.hello.value, store.rows.value, store.replay.value, fresh);
  return { now, fresh, closed };
}

function Nothing({ closed, large }: { closed: Closed[]; large: boolean }) {
  return (
    <div class="around-nothing" data-testid="around-nothing">
      <p>{t("No people or sounds yet.")}</p>
      {!large && closed.length > 1 ? <Briefly closed={closed} /> : <WithReasons closed={closed} />}
    </div>
  );
}

/** In as many lines as a small strip has. */
function Briefly({ closed }: { closed: Closed[] }) {
  return (
    <p class="muted" title={closed.map(titleOf).join("\n")}>
      {closed.map(({ text }) => text).join(" · ")}
    </p>
  );
}

function WithReasons({ closed }: { closed: Closed[] }) {
  return (
    <>
      {closed.map((one) => (
        <p key={one.what} class="muted" title={one.reason}>
          {one.reason ? t("{what}: {which}", { what: one.text, which: one.reason }) : `${one.text}.`}
        </p>
      ))}
    </>
  );
}

function titleOf({ text, reason }: Closed): string {
  return reason ? `${text}: ${reason}` : text;
}

/** What of the page lies over the strip: its age and the buttons, px of the strip. */
function coveringOf(canvas: HTMLCanvasElement): Box[] {
  const strip = canvas.getBoundingClientRect();
  const over = canvas.closest(".around")!.querySelectorAll(".around-age, .camera-tools");
  return [...over].map((element) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    return { x: left - strip.left, y: top - strip.top, width, height };
  });
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
      const now = store.clock.now(performance.now() / 1000) ?? 0;
      const stamp = panorama.stamp.peek();
      const context = canvas.getContext("2d")!;
      const density = canvas.width / strip.width;
      context.setTransform(density, 0, 0, density, 0, 0);
      const shown = {
        picture: stamp === null ? null : panorama.canvas,
        old: stamp !== null && now - stamp > OLD_S * Math.max(1, store.clock.rate),
        large,
        covered: coveringOf(canvas),
      };
      let fades = false;
      draw(context, strip, shown, (pen) => {
        for (const layer of layersOf(store)) fades = layer.draw(pen, store.of(layer.type).peek(), now) || fades;
      });
      if (fades) timer = window.setTimeout(later, FADE_STEP_MS);
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
      for (const layer of layersOf(store)) void store.of(layer.type).value;
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
