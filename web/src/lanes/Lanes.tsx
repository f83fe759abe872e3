/** The lanes: what is desired, how much of it gets through, and why, over time. One row per desire class. */

import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { typesText } from "../drive/driveController";
import { plural, t } from "../i18n";
import { shownTheme } from "../layout/theme";
import { panel } from "../panels/panel";
import { useApp } from "../state/context";
import { low, narrow } from "../ui/media";
import { EVENTS_PX } from "./drawEvents";
import { GAUGE_PX } from "./drawLanes";
import type { Feelings } from "./Feelings";
import { gaugesOf } from "./gauges";
import { Fold, LaneNames } from "./LaneNames";
import { LaneSpan, showSpan, useSpan } from "./LaneSpan";
import { LaneTable } from "./LaneTable";
import { LaneTools, Legend, SpanTools } from "./LaneTools";
import { type Pin, Pinned } from "./Pinned";
import { LIGHT, SCREEN, variables } from "./palette";
import { heightOfRows, laneRows, parted } from "./rows";
import { Tooltip } from "./Tooltip";
import { useRows } from "./useRows";

const AXIS_PX = 20;
const FOLD_PX = 24;
/** Over each of two ranges of time. */
const TOOLS_PX = 32;
/** Lanes of this width (CSS pixels) have room for two ranges of time. */
const COMPARE_PX = 860;

/** Beside the view, where there is no room for them below it. */
export const lanesPanel = panel({
  type: "lanes",
  tab: "Lanes",
  Card: Lanes,
  offered: (_, phone) => phone || low.value,
});

/** What is felt; that part of the page is loaded once something is. */
function Felt() {
  const state = useApp().store.of("emotions").value;
  const levels = state?.emotions ?? [];
  const felt = levels.some(({ intensity }) => intensity > 0);
  const part = useSignal<typeof Feelings | null>(null);
  useEffect(() => {
    if (felt) void import("./Feelings").then((loaded) => (part.value = loaded.Feelings));
  }, [felt]);
  return felt && part.value && <part.value levels={levels} shown={state?.shown ?? null} />;
}

export function Lanes() {
  const { store } = useApp();
  const rows = useRows();
  const main = useRef<HTMLDivElement>(null);
  const body = useRef<HTMLDivElement>(null);
  const [first, second] = [useSpan(), useSpan("-2")];
  const pin = useSignal<Pin | null>(null);
  const asTable = useSignal(false);
  const undesiredShown = useSignal(false);
  const gaugesShown = useSignal(false);
  const rowHeight = useSignal(32);
  const roomy = useSignal(false);
  const compare = useSignal(false);
  const pasts = useSignal(0);
  const best = useRef(1);
  const large = store.lanesLarge.value;
  const spans = compare.value && roomy.value ? [first, second] : [first];

  const offered = laneRows(rows, store.hello.value?.classes ?? []);
  const intention = store.of("intention").value;
  best.current = Math.max(best.current, intention?.omega ?? 0);
  // Which classes were desired is known better once a past has come.
  void pasts.value;
  const wasDesired = (name: string) =>
    spans.some(({ view, chart }) => {
      const from = (view.value.heldAt ?? store.lanes.newest ?? 0) - view.value.windowS;
      return (chart.current ?? store.lanes).desiredSince(name, from);
    });
  const { shown, folded } = parted(offered, wasDesired, undesiredShown.value);
  const key = shown.map((row) => row.class).join();
  const classes = useMemo(() => shown.map((row) => row.class), [key]);
  const gauges = gaugesShown.value && intention ? gaugesOf(intention, best.current) : [];
  const above = spans.length > 1 ? TOOLS_PX : 0;
  const inTab = narrow.value || low.value;
  const now = useRef({ classes, gauges, above, inTab });
  now.current = { classes, gauges, above, inTab };
  const empty = offered.length === 0;
  const drawn = !empty && !asTable.value;

  const fit = () => {
    if (!body.current) return;
    roomy.value = main.current!.clientWidth >= COMPARE_PX;
    const beside = now.current.above + EVENTS_PX + FOLD_PX + AXIS_PX + now.current.gauges.length * GAUGE_PX;
    rowHeight.value = heightOfRows(body.current.clientHeight - beside, now.current.classes.length, now.current.inTab);
  };
  useEffect(fit, [key, gauges.length, above]);
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      if (event.code !== "KeyT" || event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
      if (typesText(event.target)) return;
      event.preventDefault();
      store.lanesLarge.value = !store.lanesLarge.peek();
    };
    window.addEventListener("keydown", press);
    return () => {
      window.removeEventListener("keydown", press);
      store.lanesLarge.value = false;
    };
  }, []);
  useEffect(() => {
    if (!drawn) return;
    const observer = new ResizeObserver(fit);
    observer.observe(body.current!);
    return () => observer.disconnect();
  }, [drawn]);

  const toggleCompare = () => {
    compare.value = !compare.peek();
    if (!compare.peek() || !first.chart.current) return;
    // The second goes on from now; the first shows what was before it.
    const { windowS } = first.view.peek();
    showSpan(second, { windowS, heldAt: null });
    if (first.view.peek().heldAt === null) showSpan(first, { windowS, heldAt: first.chart.current.edges().from });
  };
  const palette = shownTheme.value === "light" ? LIGHT : SCREEN;
  const tools = (span: typeof first) => <SpanTools key={span.suffix} span={span} classes={classes} />;
  return (
    <section
      class={`lanes panel ${large ? "large" : ""}`}
      role={large && !inTab ? "main" : "region"} // they are all there is then
      aria-label={t("Lanes of desires")}
      data-testid="lanes"
      style={variables(palette)}
    >
      <header class="lanes-head">
        <h2>{t("Desires and attention")}</h2>
        <Legend />
        <div class="lanes-tools">
          {spans.length === 1 && tools(first)}
          <LaneTools asTable={asTable} compare={drawn && roomy.value ? compare : null} toggleCompare={toggleCompare} />
        </div>
      </header>
      <Felt />
      {empty && <p class="empty">{t("Waiting for the robot's desire classes…")}</p>}
      <div class="lanes-main" ref={main}>
        {drawn && (
          <div
            class={`lanes-body ${spans.length > 1 ? "compare" : ""}`}
            ref={body}
            style={{ "--row": `${rowHeight.value}px` }}
          >
            {spans.length > 1 && spans.map((span) => <div class="lanes-span-tools">{tools(span)}</div>)}
            <div class={`lane-names ${rowHeight.value >= 30 ? "scaled" : ""}`}>
              <LaneNames
                rows={shown}
                at={spans.map(({ hit }) => hit.value?.name).find((name) => name)}
                scale={store.hello.value?.scale.intensity ?? 8}
                gauges={gauges}
              />
              <div class="lane-folds">
                {(folded > 0 || undesiredShown.value) && (
                  <Fold
                    id="lanes-undesired"
                    open={undesiredShown.value}
                    words={
                      undesiredShown.value
                        ? t("Not desired")
                        : plural(folded, "{count} not desired", "{count} not desired")
                    }
                    toggle={() => (undesiredShown.value = !undesiredShown.value)}
                  />
                )}
                <Fold
                  id="lanes-budgets"
                  open={gaugesShown.value}
                  words={t("Ω and budgets")}
                  toggle={() => (gaugesShown.value = !gaugesShown.value)}
                />
              </div>
            </div>
            {spans.map((span) => (
              <LaneSpan
                key={span.suffix}
                span={span}
                shown={now}
                rowHeight={rowHeight.value}
                pin={pin}
                came={() => (pasts.value += 1)}
              />
            ))}
          </div>
        )}
        {pin.value && !asTable.value && <Pinned pin={pin.value} close={() => (pin.value = null)} />}
        <LaneTable rows={rows} visible={asTable.value} />
      </div>
      {drawn &&
        spans.map(
          ({ hit, area, chart, suffix }) =>
            hit.value &&
            area.current && (
              <Tooltip
                key={suffix}
                hit={hit.value}
                area={area.current.getBoundingClientRect()}
                top={body.current!.getBoundingClientRect().top}
                now={chart.current?.now() ?? 0}
              />
            ),
        )}
    </section>
  );
}
