/** The lanes' present values as a table: for screen readers and tests always, for eyes on demand. */

import { langOf, t } from "../i18n";
import type { LaneRow } from "../protocol/types";
import { divisor, divisorLines, number, percent, reasonText, spaced, stateWord } from "../ui/format";
import { StateMark } from "../ui/icons";

export function LaneTable({ rows, visible }: { rows: readonly LaneRow[]; visible: boolean }) {
  return (
    // It scrolls: the keyboard has to reach it.
    <div class={visible ? "lane-table" : "visually-hidden"} tabIndex={visible ? 0 : -1}>
      <table>
        <caption class="visually-hidden">{t("Desire classes now")}</caption>
        <thead>
          <tr>
            <th scope="col">{t("Class")}</th>
            <th scope="col">{t("Intensity")}</th>
            <th scope="col">{t("Utility")}</th>
            <th scope="col">{t("Rate")}</th>
            <th scope="col">φ</th>
            <th scope="col">{t("State and reason")}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr
              key={row.class}
              data-testid={`lane-${row.class}`}
              data-class={row.class}
              data-intensity={row.intensity ?? ""}
              data-utility={row.utility ?? ""}
              data-rate={row.rate ?? ""}
              data-divisor={row.divisor ?? ""}
              data-state={row.state}
            >
              <th scope="row">{spaced(row.class)}</th>
              <td>{number(row.intensity)}</td>
              <td>{number(row.utility)}</td>
              <td>{percent(row.rate)}</td>
              <td title={divisorLines(row.divisors).join("\n")}>{divisor(row.divisor)}</td>
              <td>
                <StateMark state={row.state} /> <b class="state-word">{stateWord(row.state)}</b>.{" "}
                <span lang={langOf(row.text)}>{reasonText(row.state, row.text)}</span>
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
