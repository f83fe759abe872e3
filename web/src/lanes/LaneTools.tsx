/** What the lanes are steered with, and what their lines and patterns mean. */

import type { Signal } from "@preact/signals";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { CompareIcon, EnlargeIcon, MinusIcon, PauseIcon, PlayIcon, PlusIcon, ShrinkIcon, TableIcon } from "../ui/icons";
import { type Span, showSpan } from "./LaneSpan";
import { SaveLanes } from "./SaveLanes";
import { span, stepZoom, togglePause, type Viewport } from "./viewport";

/** Zoom, pause and saving of one range of time. */
export function SpanTools({ span: of, classes }: { span: Span; classes: readonly string[] }) {
  const { store } = useApp();
  const { chart, suffix } = of;
  const view = of.view.value;
  const paused = view.heldAt !== null;
  const replay = store.replay.value;
  const show = (next: Viewport) => showSpan(of, next);
  return (
    <>
      <button
        type="button"
        class="icon-button"
        aria-label={t("Show a longer time")}
        onClick={() => show(stepZoom(view, 1))}
      >
        <MinusIcon />
      </button>
      <output class="lanes-window" data-testid={`lanes-window${suffix}`}>
        {span(view.windowS)}
      </output>
      <button
        type="button"
        class="icon-button"
        aria-label={t("Show a shorter time")}
        onClick={() => show(stepZoom(view, -1))}
      >
        <PlusIcon />
      </button>
      {(paused || !replay) && (
        <button
          type="button"
          class={`button small ${paused ? "accent" : ""}`}
          data-testid={`lanes-pause${suffix}`}
          aria-pressed={paused}
          onClick={() => show(togglePause(view, chart.current?.now() ?? 0))}
        >
          {paused ? <PlayIcon /> : <PauseIcon />}
          {!paused ? t("Pause") : replay ? t("Follow") : t("Live")}
        </button>
      )}
      <SaveLanes chart={chart} classes={classes} suffix={suffix} />
    </>
  );
}

interface Props {
  asTable: Signal<boolean>;
  /** Whether two ranges of time are shown; null: there is no room for them. */
  compare: Signal<boolean> | null;
  toggleCompare: () => void;
}

export function LaneTools({ asTable, compare, toggleCompare }: Props) {
  const { store } = useApp();
  const large = store.lanesLarge.value;
  return (
    <>
      {compare && (
        <button
          type="button"
          class={`icon-button ${compare.value ? "on" : ""}`}
          aria-label={t("Two ranges of time side by side")}
          title={t("Two ranges of time side by side")}
          aria-pressed={compare.value}
          data-testid="lanes-compare"
          onClick={toggleCompare}
        >
          <CompareIcon />
        </button>
      )}
      <button
        type="button"
        class={`icon-button ${asTable.value ? "on" : ""}`}
        aria-label={t("Show as a table")}
        aria-pressed={asTable.value}
        data-testid="lanes-table-toggle"
        onClick={() => (asTable.value = !asTable.value)}
      >
        <TableIcon />
      </button>
      <button
        type="button"
        class="icon-button"
        aria-label={large ? t("Lanes below the view (T)") : t("Lanes over the whole window (T)")}
        title={large ? t("Below the view (T)") : t("Over the whole window (T)")}
        aria-pressed={large}
        data-testid="lanes-large"
        onClick={() => (store.lanesLarge.value = !large)}
      >
        {large ? <ShrinkIcon /> : <EnlargeIcon />}
      </button>
    </>
  );
}

const SERIES = [
  ["intensity", "intensity"],
  ["utility", "desired utility"],
  ["phi", "let through (1/φ)"],
  ["measured", "measured"],
] as const;
const STATES = [
  ["exploited", "exploited"],
  ["fulfilled", "intended"],
  ["degraded", "below its best"],
  ["unfulfilled", "unfulfilled"],
  ["inhibited", "inhibited"],
] as const;

export function Legend() {
  return (
    <ul class="legend">
      {SERIES.map(([name, words]) => (
        <li key={name}>
          <i class={`key-${name}`} />
          {t(words)}
        </li>
      ))}
      {STATES.map(([name, words]) => (
        <li key={name} class="legend-state">
          <i class={`key-${name}`} />
          {t(words)}
        </li>
      ))}
    </ul>
  );
}
