/** The closed loop of attention in words. Pure. */

import { t } from "../i18n";
import type { Load } from "../protocol/types";
import { number } from "../ui/format";

/** What is left of the budget, and what the computer is like. */
export function budgetWords({
  budget,
  share,
  waiting,
}: Pick<NonNullable<Load["loop"]>, "budget" | "share" | "waiting">): string {
  const waits =
    waiting === null ? "" : t("The program waits {share} % of its time for a core.", { share: number(100 * waiting) });
  const left =
    share < 1
      ? t("Others press on the computer: attention gives {left} of {budget} %.", {
          left: number(share * budget, 1),
          budget: number(budget, 1),
        })
      : t("Attention may give the whole budget.");
  return waits ? `${left} ${waits}` : left;
}
