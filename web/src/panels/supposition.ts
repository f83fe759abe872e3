/** What is supposed, what would follow from it, and what it takes to have it so. Pure. */

import { listed, t } from "../i18n";
import type { Intention, WhatIf } from "../protocol/types";
import { number, spaced, stateWord } from "../ui/format";
import { intake, shortfall, sorted } from "./attentionText";

/** Intensities by class, 0: not desired; costs by strategy of the one resource it needs most; budgets by resource. */
export interface Supposed {
  readonly desires: Readonly<Record<string, number>>;
  readonly costs: Readonly<Record<string, Readonly<Record<string, number>>>>;
  readonly capacities: Readonly<Record<string, number>>;
}

export const NOTHING: Supposed = { desires: {}, costs: {}, capacities: {} };

export function isNothing(supposed: Supposed): boolean {
  return Object.values(supposed).every((part) => Object.keys(part).length === 0);
}

/** `part` of `supposed` with another value, or without one where the value is what there is. */
export function withValue(
  supposed: Supposed,
  part: "desires" | "capacities",
  name: string,
  value: number,
  now: number,
): Supposed {
  const { [name]: _, ...others } = supposed[part];
  return { ...supposed, [part]: value === now ? others : { ...others, [name]: value } };
}

export function withCost(supposed: Supposed, strategy: string, resource: string, cost: number, now: number): Supposed {
  const { [strategy]: _, ...others } = supposed.costs;
  return { ...supposed, costs: cost === now ? others : { ...others, [strategy]: { [resource]: cost } } };
}

/** What to ask the robot: a desire keeps its utility and security, a new one asks for any utility at all. */
export function bodyOf(supposed: Supposed, now: Intention): WhatIf {
  const desires = Object.entries(supposed.desires).map(([name, intensity]) => {
    const { utility, security } = now.asked[name] ?? { utility: 1, security: false };
    return [name, intensity > 0 ? { intensity, utility, security } : null] as const;
  });
  const costs = Object.entries(supposed.costs).map(([name, cost]) => [name, { ...cost }] as const);
  return {
    desires: Object.fromEntries(desires),
    costs: Object.fromEntries(costs),
    capacities: { ...supposed.capacities },
  };
}

/** What one class would get, beside what it gets. */
export interface Difference {
  readonly name: string;
  readonly before: string;
  readonly after: string;
  readonly better: boolean;
}

/** The classes that would be served otherwise, those that lose first. */
export function differences(now: Intention, then: Intention): Difference[] {
  const names = [
    ...new Set([...Object.keys(now.reasons), ...Object.keys(then.reasons), ...served(now), ...served(then)]),
  ];
  return names
    .map((name) => ({
      name,
      before: wordsOf(now, name),
      after: wordsOf(then, name),
      gain: utilityOf(then, name) - utilityOf(now, name),
    }))
    .filter(({ before, after }) => before !== after)
    .sort((a, b) => a.gain - b.gain)
    .map(({ gain, ...rest }) => ({ ...rest, better: gain > 0 }));
}

/** What would be given up, in one sentence. */
export function supposedHeadline(reasons: Intention["reasons"]): string {
  const { given, best } = sorted(reasons);
  if (given.length + best.length === 0) return t("Nothing would be desired: the robot would attend to nothing.");
  const of = (state: string) =>
    listed(given.filter(([, reason]) => reason.state === state).map(([name]) => spaced(name)));
  const parts = [
    of("unfulfilled") && t("give up {classes}", { classes: of("unfulfilled") }),
    of("degraded") && t("give less to {classes}", { classes: of("degraded") }),
    of("inhibited") && t("hold back {classes}", { classes: of("inhibited") }),
  ].filter(Boolean);
  if (parts.length === 0) return t("Everything that is desired would get all it can use.");
  return t("The robot would {deeds}.", { deeds: parts.join(", ") });
}

/** In short, what a class would get, where that is something else: "→ 50 % of its best". */
export function outcome(now: Intention, then: Intention, name: string): string {
  const [before, after] = [stateOf(now, name), stateOf(then, name)];
  return before === after ? "" : `→ ${after}`;
}

function served(intention: Intention): string[] {
  return intention.strategies.map((strategy) => strategy.class);
}

function utilityOf(intention: Intention, name: string): number {
  return strategiesFor(intention, name).reduce((sum, { utility }) => sum + utility, 0);
}

/** "fulfilled, camera: every second picture". */
function wordsOf(intention: Intention, name: string): string {
  return [stateOf(intention, name), ...intake(strategiesFor(intention, name))].join(", ");
}

function stateOf(intention: Intention, name: string): string {
  const reason = intention.reasons[name];
  if (reason) return shortfall(reason) || stateWord(reason.state);
  return strategiesFor(intention, name).length > 0 ? t("needed by another") : t("not desired");
}

function strategiesFor(intention: Intention, name: string) {
  return intention.strategies.filter((strategy) => strategy.class === name);
}

/** One thing that is set to have it so. Costs are measured, and not set. */
export interface Deed {
  readonly kind: "capacity" | "intensity" | "remove" | "add";
  /** The resource, or the desire class. */
  readonly name: string;
  readonly value: number;
}

export function deedsOf(supposed: Supposed, now: Intention): Deed[] {
  const budgets = Object.entries(supposed.capacities).map(
    ([name, value]) => ({ kind: "capacity", name, value }) as const,
  );
  const desires = Object.entries(supposed.desires).map(([name, value]) => {
    const kind = value === 0 ? "remove" : now.desires[name] === undefined ? "add" : "intensity";
    return { kind, name, value } as const;
  });
  return [...budgets, ...desires];
}

/** `label` and `unit` of a resource. */
export function deedWords({ kind, name, value }: Deed, label: string, unit: string): string {
  switch (kind) {
    case "capacity":
      return t("{label}: at most {value} {unit}", { label, value: number(value), unit });
    case "intensity":
      return t("{name}: intensity {value}", { name: spaced(name), value: number(value) });
    case "add":
      return t("{name}: a new desire of intensity {value}", { name: spaced(name), value: number(value) });
    case "remove":
      return t("{name}: its strongest desire is removed", { name: spaced(name) });
  }
}

/** The resource of which a strategy needs most, as a share of the budget; null: it costs nothing. */
export function dearest(costs: Readonly<Record<string, number>>, use: Intention["use"]): string | null {
  const share = (name: string) => costs[name]! / Math.max(use[name]?.capacity ?? 1, 1e-9);
  const names = Object.keys(costs).filter((name) => costs[name]! > 0);
  return names.reduce<string | null>((best, name) => (best && share(best) >= share(name) ? best : name), null);
}
