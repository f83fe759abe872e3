/** Hands on the lanes: hover, drag to pan, wheel and pinch to zoom, arrow keys for the cursor. Returns the undoing. */

import { EVENTS_ROW, type LaneChart } from "./chart";
import { EVENTS_PX } from "./drawEvents";
import { pan, stepZoom, togglePause, type Viewport, zoom } from "./viewport";

const DRAG_PX = 4;

interface Report {
  view(next: Viewport): void;
  cursor(): void;
  /** An instant was clicked. */
  pick(share: number, row: number): void;
}

export function gestures(area: HTMLElement, chart: LaneChart, report: Report): () => void {
  const pointers = new Map<number, { x: number; y: number }>();
  let dragged = 0;

  const place = (event: { clientX: number; clientY: number }) => {
    const box = area.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top - EVENTS_PX, width: Math.max(1, box.width) };
  };
  const point = (event: PointerEvent) => {
    const { x, y, width } = place(event);
    chart.cursor = {
      share: Math.max(0, Math.min(1, x / width)),
      row: onEvents(event) ? EVENTS_ROW : Math.floor(y / chart.rowHeight),
    };
    report.cursor();
  };
  // Its row stays in view, over those that are scrolled under it.
  const onEvents = (event: Event) => (event.target as Element).closest(".lane-events") !== null;
  const pick = () => chart.cursor && report.pick(chart.cursor.share, chart.cursor.row);
  const clear = () => {
    chart.cursor = null;
    report.cursor();
  };

  const down = (event: PointerEvent) => {
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    dragged = 0;
  };
  const move = (event: PointerEvent) => {
    const before = pointers.get(event.pointerId);
    if (before) {
      const width = place(event).width;
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)![1];
        const was = Math.abs(before.x - other.x);
        const is = Math.abs(event.clientX - other.x);
        if (was > 10 && is > 10) report.view(zoom(chart.view, is / was, 0.5));
      } else {
        dragged += Math.abs(event.clientX - before.x);
        if (dragged > DRAG_PX) {
          if (!area.hasPointerCapture(event.pointerId)) area.setPointerCapture(event.pointerId);
          const seconds = ((event.clientX - before.x) / width) * chart.view.windowS;
          report.view(pan(chart.view, seconds, chart.now(), chart.oldest()));
        }
      }
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    }
    point(event);
  };
  const up = (event: PointerEvent) => {
    pointers.delete(event.pointerId);
    if (event.type !== "pointerup" || dragged > DRAG_PX) return;
    point(event);
    pick();
  };
  const leave = (event: PointerEvent) => {
    pointers.delete(event.pointerId);
    if (event.pointerType !== "touch") clear();
  };
  const wheel = (event: WheelEvent) => {
    if (event.shiftKey) return;
    event.preventDefault();
    const { x, width } = place(event);
    report.view(zoom(chart.view, Math.exp(-event.deltaY * 0.0016), x / width));
  };
  const key = (event: KeyboardEvent) => {
    const cursor = chart.cursor ?? { share: 0.95, row: 0 };
    const stepShare = event.shiftKey ? 0.1 : 0.01;
    const rows = chart.rows;
    if (event.key === "ArrowLeft") chart.cursor = { ...cursor, share: Math.max(0, cursor.share - stepShare) };
    else if (event.key === "ArrowRight") chart.cursor = { ...cursor, share: Math.min(1, cursor.share + stepShare) };
    else if (event.key === "ArrowUp") chart.cursor = { ...cursor, row: Math.max(EVENTS_ROW, cursor.row - 1) };
    else if (event.key === "ArrowDown") chart.cursor = { ...cursor, row: Math.min(rows - 1, cursor.row + 1) };
    else if (event.key === "+" || event.key === "=") report.view(stepZoom(chart.view, -1));
    else if (event.key === "-") report.view(stepZoom(chart.view, 1));
    else if (event.key === "Enter") pick();
    else if (event.code === "KeyP") report.view(togglePause(chart.view, chart.now()));
    else return;
    event.preventDefault();
    report.cursor();
  };

  // A click looks, it does not take the arrow keys away from driving; Tab does.
  const stay = (event: Event) => event.preventDefault();

  const listeners: [string, (event: never) => void][] = [
    ["pointerdown", down],
    ["mousedown", stay],
    ["pointermove", move],
    ["pointerup", up],
    ["pointercancel", up],
    ["pointerleave", leave],
    ["keydown", key],
    ["blur", clear],
  ];
  for (const [type, listener] of listeners) area.addEventListener(type, listener as EventListener);
  area.addEventListener("wheel", wheel, { passive: false });
  return () => {
    for (const [type, listener] of listeners) area.removeEventListener(type, listener as EventListener);
    area.removeEventListener("wheel", wheel);
  };
}
