/** The lanes over one range of time, with its own zoom, pan and pause: alone, or one of two side by side. */

import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { clockSpan, clockTime } from "../ui/format";
import { Axis, TimeLines } from "./Axis";
import { type Hit, LaneChart, type Shown } from "./chart";
import { EVENTS_PX } from "./drawEvents";
import { gestures } from "./gestures";
import type { Pin } from "./Pinned";
import { whileSeen } from "./seen";
import { INITIAL, ticks, type Viewport } from "./viewport";

export interface Span {
  /** Of several: "" the first, "-2" the second. */
  suffix: string;
  chart: RefObject<LaneChart | null>;
  area: RefObject<HTMLDivElement | null>;
  view: Signal<Viewport>;
  hit: Signal<Hit | null>;
}

export function useSpan(suffix = ""): Span {
  const chart = useRef<LaneChart>(null);
  const area = useRef<HTMLDivElement>(null);
  return { suffix, chart, area, view: useSignal<Viewport>(INITIAL), hit: useSignal<Hit | null>(null) };
}

export function showSpan({ view, chart }: Span, next: Viewport): void {
  view.value = next;
  if (chart.current) chart.current.view = next;
}

interface Props {
  span: Span;
  shown: { readonly current: Shown };
  rowHeight: number;
  pin: Signal<Pin | null>;
  /** A past that was asked for has come. */
  came: () => void;
}

export function LaneSpan({ span, shown, rowHeight, pin, came }: Props) {
  const { store, session } = useApp();
  const lanes = useRef<HTMLCanvasElement>(null);
  const events = useRef<HTMLCanvasElement>(null);
  const overlay = useRef<HTMLDivElement>(null);
  const width = useSignal(1);
  const height = useRef(rowHeight);
  height.current = rowHeight;
  const { area, chart, hit, view, suffix } = span;

  const fit = () => {
    if (!area.current) return;
    width.value = area.current.clientWidth;
    chart.current?.resize(width.value, height.current);
  };
  useEffect(fit, [rowHeight]);
  useEffect(() => {
    const made = new LaneChart(
      { lanes: lanes.current!, events: events.current!, overlay: overlay.current! },
      store,
      { rest: session.rest, came },
      () => shown.current,
      () => made.cursor && (hit.value = made.hit()),
    );
    made.view = view.peek();
    chart.current = made;
    fit();
    const observer = new ResizeObserver(fit);
    observer.observe(area.current!);
    const stopSeeing = whileSeen(area.current!, (seen) => made.see(seen));
    const stop = gestures(area.current!, made, {
      view: (next) => (view.value = made.view = next),
      cursor: () => (hit.value = made.hit()),
      pick: (share) => (pin.value = pinned(made, made.stampAt(share))),
    });
    return () => {
      made.see(false);
      stopSeeing();
      observer.disconnect();
      stop();
      chart.current = null;
      hit.value = null;
    };
  }, []);
  useEffect(() => chart.current?.soon(), [pin.value]);

  const { heldAt, windowS } = view.value;
  const marks = ticks(windowS, width.value, useEdgeWord(heldAt));
  return (
    <>
      <div
        class="lane-area"
        data-testid={`lane-area${suffix}`}
        ref={area}
        // biome-ignore lint/a11y/noNoninteractiveTabindex: its keys move a cursor over the lanes
        tabIndex={0}
        data-own-arrows
        role="group"
        aria-label={`${suffix ? t("Second range of time") : t("Lanes over time")}. ${t("Arrow keys move a cursor that shows values and reasons, Enter pins the instant, plus and minus zoom, P pauses.")}`}
      >
        <TimeLines ticks={marks} />
        <div class="lane-events">
          <canvas ref={events} />
        </div>
        <canvas class="lane-strip" ref={lanes} data-testid={`lane-canvas${suffix}`} />
        <div class="lane-overlay" ref={overlay}>
          {pin.value && <i data-stamp={pin.value.stamp} />}
        </div>
        {hit.value && <Cursor hit={hit.value} />}
      </div>
      <Axis ticks={marks} suffix={suffix} />
    </>
  );
}

function pinned(chart: LaneChart, stamp: number): Pin {
  const samples = chart
    .samples(stamp)
    .filter(({ sample }) => sample.state !== "undesired")
    .map((each) => ({ ...each, exploited: chart.exploits(each.name, stamp) }));
  return { stamp, intention: chart.intention(stamp), samples };
}

/** What the right edge is called: a recording has no present. */
function useEdgeWord(heldAt: number | null): string {
  const { store } = useApp();
  const playback = store.playback.value;
  if (playback) return clockSpan((heldAt ?? store.now.value ?? playback.begin) - playback.begin);
  return heldAt === null ? t("now") : clockTime(heldAt);
}

function Cursor({ hit }: { hit: Hit }) {
  const top = hit.y + EVENTS_PX;
  return (
    <>
      <i class="lane-cursor-row" style={{ top: `${top}px`, height: `${hit.height}px` }} />
      <i class="lane-cursor" style={{ transform: `translateX(${Math.round(hit.x)}px)` }} />
    </>
  );
}
