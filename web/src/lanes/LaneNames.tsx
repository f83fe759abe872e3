/** The names beside the lanes, with the present figures; below them what is folded. */

import { t } from "../i18n";
import type { LaneRow } from "../protocol/types";
import { divisor, divisorLines, number, spaced } from "../ui/format";
import { ChevronIcon, StateMark } from "../ui/icons";
import type { Gauge } from "./drawLanes";

interface Props {
  rows: readonly LaneRow[];
  /** Class under the cursor. */
  at: string | undefined;
  scale: number;
  gauges: readonly Gauge[];
}

export function LaneNames({ rows, at, scale, gauges }: Props) {
  return (
    <ol aria-hidden="true">
      <li class="lane-heads">
        <b>{t("intensity")}</b>
        <em>{t("utility")}</em>
        <i>{t("let through")}</i>
      </li>
      {rows.map((row) => (
        <li key={row.class} class={`lane-name ${row.state} ${at === row.class ? "at" : ""}`}>
          <StateMark state={row.state} />
          <span class="lane-title">{spaced(row.class)}</span>
          <span class="lane-figures">
            <b title={t("Intensity")}>{number(row.intensity)}</b>
            <em title={t("Desired utility")}>{number(row.utility)}</em>
            <i title={[t("Messages let through"), ...divisorLines(row.divisors)].join("\n")}>{divisor(row.divisor)}</i>
          </span>
          <span class="lane-scale">
            <i>{scale}</i>
            <i>{scale / 2}</i>
            <i>0</i>
          </span>
        </li>
      ))}
      {gauges.map((gauge) => (
        <li key={gauge.name} class="lane-gauge">
          <span class="lane-title">{gauge.title}</span>
          <span class="lane-figures">{gauge.figure}</span>
        </li>
      ))}
    </ol>
  );
}

/** A line that opens what is folded. */
export function Fold({ open, words, id, toggle }: { open: boolean; words: string; id: string; toggle: () => void }) {
  return (
    <button
      type="button"
      class={`lane-fold ${open ? "open" : ""}`}
      aria-expanded={open}
      data-testid={id}
      onClick={toggle}
    >
      <ChevronIcon />
      {words}
    </button>
  );
}
