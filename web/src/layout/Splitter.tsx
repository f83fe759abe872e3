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
  const dragged = useRef(false);
  const put = (value: number) => layout.change({ [part.key]: value });
  const follow = (event: PointerEvent) => {
    if (!dragged.current) return;
    const across = event.clientX / window.innerWidth;
    put(part.key === "lanes" ? 1 - event.clientY / window.innerHeight : left ? across : 1 - across);
  };
  const grows = part.key === "lanes" ? "ArrowUp" : left ? "ArrowRight" : "ArrowLeft";
  const shrinks = part.key === "lanes" ? "ArrowDown" : left ? "ArrowLeft" : "ArrowRight";
  const end = () => (dragged.current = false);
  return (
    <div
      class={`splitter ${part.key}-splitter`}
      data-testid={`${part.key}-splitter`}
      role="separator"
      tabIndex={0}
      data-own-arrows
      aria-label={t(part.name)}
      aria-orientation={part.key === "lanes" ? "horizontal" : "vertical"}
      aria-valuenow={Math.round(100 * share)}
      aria-valuemin={Math.round(100 * part.shares.least)}
      aria-valuemax={Math.round(100 * part.shares.most)}
      title={t("Drag, or use the arrow keys; a double click puts it back")}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.preventDefault();
        event.currentTarget.setPointerCapture(event.pointerId);
        dragged.current = true;
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
