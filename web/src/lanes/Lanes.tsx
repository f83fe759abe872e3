/** The lanes: what is desired, how much of it gets through, and why, over time. One row per desire class. */

import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { panel } from "../panels/panel";
import { useApp } from "../state/context";
import { divisor, divisorLines, number, spaced } from "../ui/format";
import { MinusIcon, PauseIcon, PlayIcon, PlusIcon, StateMark, TableIcon } from "../ui/icons";
import { narrow } from "../ui/media";
import { type Hit, LaneChart } from "./chart";
import { AXIS_PX } from "./drawLanes";
import { gestures } from "./gestures";
import { LaneTable } from "./LaneTable";
import { laneRows } from "./rows";
import { Tooltip } from "./Tooltip";
import { span, stepZoom, togglePause, type Viewport } from "./viewport";

const ROW_MIN = 20;
/** On a phone the figures stand below the name. */
const ROW_MIN_NARROW = 34;
const ROW_MAX = 72;

/** Beside the view, where there is no room for them below it. */
export const lanesPanel = panel({ type: "lanes", tab: "Lanes", Card: Lanes, offered: (_, phone) => phone });

export function Lanes() {
  const { store } = useApp();
  const rows = laneRows(store.rows.value, store.hello.value?.classes ?? []);
  const canvas = useRef<HTMLCanvasElement>(null);
  const body = useRef<HTMLDivElement>(null);
  const area = useRef<HTMLDivElement>(null);
  const view = useSignal<Viewport>({ windowS: 30, heldAt: null });
  const hit = useSignal<Hit | null>(null);
  const asTable = useSignal(false);
  const rowHeight = useSignal(32);
  const chart = useRef<LaneChart | null>(null);
  const classes = useMemo(() => rows.map((row) => row.class), [rows.map((row) => row.class).join()]);
  const classesNow = useRef(classes);
  classesNow.current = classes;
  const empty = rows.length === 0;

  useEffect(() => {
    if (empty || asTable.value) return;
    const made = new LaneChart(canvas.current!, store, () => classesNow.current);
    made.view = view.peek();
    chart.current = made;
    const measure = () => {
      if (!body.current || !area.current) return;
      const head =
        area.current.getBoundingClientRect().top - body.current.getBoundingClientRect().top + body.current.scrollTop;
      const room = (body.current.clientHeight - head - AXIS_PX) / Math.max(1, classesNow.current.length);
      rowHeight.value = Math.max(narrow.peek() ? ROW_MIN_NARROW : ROW_MIN, Math.min(ROW_MAX, Math.floor(room)));
      made.resize(area.current.clientWidth, rowHeight.value);
    };
    const observer = new ResizeObserver(measure);
    observer.observe(body.current!);
    observer.observe(area.current!);
    const stop = gestures(area.current!, made, {
      view: (next) => (view.value = made.view = next),
      cursor: () => (hit.value = made.hit()),
    });
    let frame = requestAnimationFrame(function next() {
      made.frame();
      frame = requestAnimationFrame(next);
    });
    const refresh = window.setInterval(() => made.cursor && (hit.value = made.hit()), 100);
    return () => {
      cancelAnimationFrame(frame);
      clearInterval(refresh);
      observer.disconnect();
      stop();
      chart.current = null;
      hit.value = null;
    };
  }, [empty, asTable.value, classes.length]);

  const show = (next: Viewport) => {
    view.value = next;
    if (chart.current) chart.current.view = next;
  };
  const paused = view.value.heldAt !== null;
  const replay = store.replay.value;

  return (
    <section class="lanes panel" aria-label="Lanes of desires" data-testid="lanes">
      <header class="lanes-head">
        <h2>Desires and attention</h2>
        <Legend />
        <div class="lanes-tools">
          <button
            type="button"
            class="icon-button"
            aria-label="Show a longer time"
            onClick={() => show(stepZoom(view.value, 1))}
          >
            <MinusIcon />
          </button>
          <output class="lanes-window" data-testid="lanes-window">
            {span(view.value.windowS)}
          </output>
          <button
            type="button"
            class="icon-button"
            aria-label="Show a shorter time"
            onClick={() => show(stepZoom(view.value, -1))}
          >
            <PlusIcon />
          </button>
          {(paused || !replay) && (
            <button
              type="button"
              class={`button small ${paused ? "accent" : ""}`}
              data-testid="lanes-pause"
              aria-pressed={paused}
              onClick={() => show(togglePause(view.value, chart.current?.now() ?? 0))}
            >
              {paused ? <PlayIcon /> : <PauseIcon />}
              {!paused ? "Pause" : replay ? "Follow" : "Live"}
            </button>
          )}
          <button
            type="button"
            class={`icon-button ${asTable.value ? "on" : ""}`}
            aria-label="Show as a table"
            aria-pressed={asTable.value}
            data-testid="lanes-table-toggle"
            onClick={() => (asTable.value = !asTable.value)}
          >
            <TableIcon />
          </button>
        </div>
      </header>
      {empty && <p class="empty">Waiting for the robot's desire classes…</p>}
      {!empty && !asTable.value && (
        <div class="lanes-body" ref={body} style={{ "--row": `${rowHeight.value}px` }}>
          <ol class="lane-names" aria-hidden="true">
            <li class="lane-heads">
              <b>intensity</b>
              <em>utility</em>
              <i>let through</i>
            </li>
            {rows.map((row) => (
              <li key={row.class} class={`lane-name ${row.state} ${hit.value?.name === row.class ? "at" : ""}`}>
                <StateMark state={row.state} />
                <span class="lane-title">{spaced(row.class)}</span>
                <span class="lane-figures">
                  <b title="Intensity">{number(row.intensity)}</b>
                  <em title="Desired utility">{number(row.utility)}</em>
                  <i title={["Messages let through", ...divisorLines(row.divisors)].join("\n")}>
                    {divisor(row.divisor)}
                  </i>
                </span>
              </li>
            ))}
          </ol>
          <div
            class="lane-area"
            ref={area}
            // biome-ignore lint/a11y/noNoninteractiveTabindex: its keys move a cursor over the lanes
            tabIndex={0}
            data-own-arrows
            role="group"
            aria-label="Lanes over time. Arrow keys move a cursor that shows values and reasons, plus and minus zoom, P pauses."
          >
            <canvas ref={canvas} data-testid="lane-canvas" />
          </div>
        </div>
      )}
      {hit.value && !asTable.value && (
        <Tooltip
          hit={hit.value}
          area={area.current!.getBoundingClientRect()}
          top={body.current!.getBoundingClientRect().top}
          now={chart.current?.now() ?? 0}
        />
      )}
      <LaneTable visible={asTable.value} />
    </section>
  );
}

function Legend() {
  return (
    <ul class="legend">
      <li>
        <i class="key-intensity" />
        intensity
      </li>
      <li>
        <i class="key-utility" />
        desired utility
      </li>
      <li>
        <i class="key-rate" />
        relative message rate
      </li>
      <li class="only-wide">
        <i class="key-mark" />
        event
      </li>
    </ul>
  );
}
