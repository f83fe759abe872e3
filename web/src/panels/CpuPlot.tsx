/** CPU over the last minutes: what attention governs against its budget, and the whole process. */

import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { t } from "../i18n";
import "uplot/dist/uPlot.min.css";
import { shownTheme } from "../layout/theme";
import { useApp } from "../state/context";
import { clockTime } from "../ui/format";

const HEIGHT = 110;
/** A colour of the page's theme. */
const tone = (name: string) => () => getComputedStyle(document.documentElement).getPropertyValue(name);
const AXIS = {
  stroke: tone("--muted"),
  grid: { stroke: tone("--hover"), width: 1 },
  ticks: { show: false },
  font: "11px system-ui, sans-serif",
};

export function CpuPlot() {
  const { store } = useApp();
  const place = useRef<HTMLDivElement>(null);
  const history = store.loadHistory.value;
  const plot = useRef<uPlot | null>(null);

  useEffect(() => {
    const host = place.current!;
    const made = new uPlot(
      {
        width: Math.max(200, host.clientWidth),
        height: HEIGHT,
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: true }, y: { range: (_, __, max) => [0, Math.max(10, (max ?? 0) * 1.15)] } },
        axes: [
          {
            ...AXIS,
            size: 22,
            values: (_, at) => at.map((stamp) => clockTime(stamp)),
            space: 70,
          },
          { ...AXIS, size: 40, values: (_, at) => at.map((v) => `${v} %`), space: 28 },
        ],
        series: [
          {},
          { stroke: tone("--muted"), width: 1, points: { show: false } },
          { stroke: tone("--accent"), fill: "rgba(61,127,230,.28)", width: 1.5, points: { show: false } },
          { stroke: tone("--warn"), width: 1.5, dash: [5, 4], points: { show: false } },
        ],
      },
      [[], [], [], []],
      host,
    );
    plot.current = made;
    const observer = new ResizeObserver(() => made.setSize({ width: Math.max(200, host.clientWidth), height: HEIGHT }));
    observer.observe(host);
    return () => {
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, []);
  useEffect(() => {
    plot.current?.setData([
      history.map((p) => p.stamp),
      history.map((p) => p.cpu),
      history.map((p) => p.attended),
      history.map((p) => p.budget),
    ]);
  }, [history, shownTheme.value]);

  return (
    <figure class="cpu-plot">
      <div ref={place} role="img" aria-label={t("CPU over the last minutes")} />
      <figcaption class="muted small">
        <i class="key-process" /> {t("whole process")} <i class="key-cpu" /> {t("governed")} <i class="key-budget" />{" "}
        {t("budget")}
      </figcaption>
    </figure>
  );
}
