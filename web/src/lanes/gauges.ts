/** Ω and the budgets as lanes, from the intention in force. Pure. */

import { named, t } from "../i18n";
import type { Intention } from "../protocol/types";
import { number, spaced } from "../ui/format";
import type { Gauge } from "./drawLanes";
import type { IntentionStep } from "./timelineOf";

/** `best`: the greatest Ω seen, which the lane of Ω is scaled to. */
export function gaugesOf(intention: Intention, best: number): Gauge[] {
  const omega = {
    name: "omega",
    title: "Ω",
    figure: number(intention.omega),
    most: Math.max(1, best),
    budget: null,
    value: (step: IntentionStep) => step.omega,
  };
  const budgets = Object.entries(intention.use).map(([name, use]) => ({
    name,
    title: name.length <= 3 ? name.toUpperCase() : spaced(name),
    figure: t("{used} of {capacity} {unit}", {
      used: number(use.used),
      capacity: number(use.capacity),
      unit: named(use.unit),
    }),
    most: Math.max(use.capacity, use.used) * 1.05 || 1,
    budget: use.capacity,
    value: (step: IntentionStep) => step.use[name] ?? 0,
  }));
  return [omega, ...budgets];
}
