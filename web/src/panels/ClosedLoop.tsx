/** What attention makes of the load: each strategy's CPU as declared, measured and reckoned with, and what others press. */

import { fromRobot, langOf, t } from "../i18n";
import type { Load } from "../protocol/types";
import { number, spaced } from "../ui/format";
import { budgetWords } from "./closedLoopText";

type Loop = NonNullable<Load["loop"]>;

export function ClosedLoop({ loop }: { loop: Loop }) {
  return (
    <section class="closed-loop" data-testid="closed-loop" data-share={loop.share}>
      <p class="muted small" data-testid="closed-loop-words">
        {budgetWords(loop)}
      </p>
      {loop.why && (
        <p class="muted small" lang={langOf(loop.why)}>
          {fromRobot(loop.why)}
        </p>
      )}
      {loop.strategies.length > 0 && (
        <details>
          <summary>{t("Costs: declared, measured, reckoned with")}</summary>
          <table>
            <thead>
              <tr>
                <th scope="col">{t("Serves")}</th>
                <th scope="col">{t("Declared %")}</th>
                <th scope="col">{t("Measured %")}</th>
                <th scope="col">{t("Reckoned %")}</th>
              </tr>
            </thead>
            <tbody>
              {loop.strategies.map((each) => (
                <tr key={each.name} data-testid={`cost-${each.name}`}>
                  <th scope="row" title={each.name}>
                    {spaced(each.class)}
                  </th>
                  <td>{number(each.declared, 1)}</td>
                  <td>{each.measured === null ? "–" : number(each.measured, 1)}</td>
                  <td class={differs(each.declared, each.used) ? "some" : ""}>{number(each.used, 1)}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </details>
      )}
    </section>
  );
}

function differs(one: number, other: number): boolean {
  return Math.abs(one - other) > 0.1 * Math.max(one, other);
}
