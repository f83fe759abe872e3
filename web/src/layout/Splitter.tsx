/** A separator between two parts of the page: dragged, moved by arrow keys, put back by a double click. */

import { useRef } from "preact/hooks";
import { type Text, t } from "../i18n";
import { useApp } from "../state/context";
import { DEFAULTS, LANES_SHARES, SIDE_SHARES } from "./layout";

/** Of the window, by one press of an arrow key. */
const STEP = 0.02;

interface Part {
  name: Text;
  key: "side" | "lanes";
  shares: { least: number; most: number };
}
const SIDE: Part = { name: "Width of the panels", key: "side", shares: SIDE_SHARES };
const LANES: Part = { name: "Height of the lanes", key: "lanes", shares: LANES_SHARES };

export const SideSplitter = () => <Splitter part={SIDE} />;
export const LanesSplitter = () => <Splitter part={LANES} />;

function Splitter({ part }: { part: Part }) {
  const { layout } = useApp();
  const share = layout.layout.value[part.key];
  const left = layout.layout.value.edge === "left";
  const top = layout.layout.value.lanesAt === "top";
  const lanes = part.key === "lanes";
  /** Where (px) and of which share a drag began; null: none. */
  const dragged = useRef<{ at: number; share: number } | null>(null);
  const put = (value: number) => layout.change({ [part.key]: value });
  const along = (event: PointerEvent) => (lanes ? event.clientY : event.clientX);
  const follow = (event: PointerEvent) => {
    if (!dragged.current) return;
    const by = (along(event) - dragged.current.at) / (lanes ? window.innerHeight : window.innerWidth);
    put(dragged.current.share + ((lanes ? top : left) ? by : -by));
  };
  const grows = lanes ? (top ? "ArrowDown" : "ArrowUp") : left ? "ArrowRight" : "ArrowLeft";
  const shrinks = lanes ? (top ? "ArrowUp" : "ArrowDown") : left ? "ArrowLeft" : "ArrowRight";
  const end = () => (dragged.current = null);
  return (
    <div
      class={`splitter ${part.key}-splitter`}
      data-testid={`${part.key}-splitter`}
      role="separator"
      tabIndex={0}
      data-own-arrows
      aria-label={t(part.name)}
      aria-orientation={lanes ? "horizontal" : "vertical"}
      aria-valuenow={Math.round(100 * share)}
      aria-valuemin={Math.round(100 * part.shares.least)}
      aria-valuemax={Math.round(100 * part.shares.most)}
      title={t("Drag, or use the arrow keys; a double click puts it back")}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.preventDefault();
        event.currentTarget.setPointerCapture(event.pointerId);
        dragged.current = { at: along(event), share };
      }}
      onPointerMove={follow}
      onPointerUp={end}
      onPointerCancel={end}
      onDblClick={() => put(DEFAULTS[layout.preset.peek()][part.key])}
      onKeyDown={(event) => {
        const by = event.key === grows ? STEP : event.key === shrinks ? -STEP : 0;
        if (by === 0) return;
        event.preventDefault();
        put(share + by);
      }}
    />
  );
}
