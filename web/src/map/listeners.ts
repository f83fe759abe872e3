/** Joins the browser's pointers, wheel and keys to the tools of the map. */

import { t } from "../i18n";
import { number } from "../ui/format";
import { handleAt, type MapControl } from "./mapControl";
import { type Point, toScreen } from "./mapProjection";

/** Pointers, wheel and keys into the state machine; returns the undoing. `say` is for who does not see the cursor. */
export function listen(canvas: HTMLCanvasElement, map: MapControl, say: (words: string) => void): () => void {
  const at = (event: MouseEvent): Point => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const down = (event: PointerEvent) => {
    if (!map.allowed.peek() && map.tools.peek().tool !== "look") return;
    canvas.setPointerCapture(event.pointerId);
    const { view, size } = map.sight;
    const handle = handleAt(map.zones.peek(), map.selected.peek(), at(event), (point) => toScreen(view, size, point));
    map.input({ type: "down", id: event.pointerId, at: at(event), button: event.button, handle });
  };
  const move = (event: PointerEvent) => void map.input({ type: "move", id: event.pointerId, at: at(event) });
  const up = (event: PointerEvent) => void map.input({ type: "up", id: event.pointerId, at: at(event) });
  const cancel = (event: PointerEvent) => void map.input({ type: "cancel", id: event.pointerId });
  const leave = () => void map.input({ type: "leave" });
  const wheel = (event: WheelEvent) => {
    event.preventDefault();
    map.input({ type: "wheel", at: at(event), factor: Math.exp(-event.deltaY * 0.0016) });
  };
  const key = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.key === "Escape") return;
    if (event.key === "Enter" && !map.allowed.peek()) return;
    if (!map.input({ type: "key", key: event.key, shift: event.shiftKey })) return;
    event.preventDefault();
    event.stopPropagation();
    say(cursorWords(map));
  };
  // Only where the keyboard brought the focus there.
  const focus = () => map.input({ type: "focus", on: canvas.matches(":focus-visible") });
  const blur = () => map.input({ type: "focus", on: false });
  // A click looks, it does not take the arrow keys away from driving; Tab does.
  const stay = (event: Event) => event.preventDefault();
  const listeners: [string, (event: never) => void][] = [
    ["pointerdown", down],
    ["pointermove", move],
    ["pointerup", up],
    ["pointercancel", cancel],
    ["pointerleave", leave],
    ["mousedown", stay],
    ["contextmenu", stay],
    ["keydown", key],
    ["focus", focus],
    ["blur", blur],
  ];
  for (const [type, listener] of listeners) canvas.addEventListener(type, listener as EventListener);
  canvas.addEventListener("wheel", wheel, { passive: false });
  return () => {
    for (const [type, listener] of listeners) canvas.removeEventListener(type, listener as EventListener);
    canvas.removeEventListener("wheel", wheel);
  };
}

function cursorWords(map: MapControl): string {
  const { cursor, act, corners } = map.tools.peek();
  if (!cursor) return "";
  const where = t("{x}, {y} metres", { x: number(cursor.x, 1), y: number(cursor.y, 1) });
  if (act.kind === "aim") {
    const heading =
      act.heading === null
        ? t("no heading yet")
        : t("heading {degrees} degrees", { degrees: number((act.heading * 180) / Math.PI, 0) });
    return t("Place {where}, {heading}. Arrows turn it, Enter sends it, Escape cancels.", { where, heading });
  }
  return corners.length > 0 ? t("Corner {number} at {where}", { number: corners.length + 1, where }) : where;
}
