/** What the lanes show of the robot's events: what was exploited, Ω and budgets, and those of no class, folded. Pure. */

import { fromRobot, langOf, named } from "../i18n";
import type { RobotEvent } from "../protocol/types";

export interface Spell {
  from: number;
  to: number;
}

/** When a behavior exploited desires of each class; a spell that still goes on ends at infinity. */
export function exploitedSpells(events: readonly RobotEvent[]): Map<string, Spell[]> {
  const found = new Map<string, Spell[]>();
  const open = new Map<string, Set<string>>();
  for (const { kind, subject, stamp, data } of events) {
    if (kind !== "exploitation") continue;
    const classes = new Set(data["exploited"] ? (data["classes"] as string[]) : []);
    for (const [name, behaviors] of open) {
      if (classes.has(name) || !behaviors.delete(subject) || behaviors.size > 0) continue;
      found.get(name)!.at(-1)!.to = stamp;
    }
    for (const name of classes) {
      const behaviors = open.get(name) ?? new Set();
      open.set(name, behaviors);
      if (behaviors.size === 0) found.set(name, [...(found.get(name) ?? []), { from: stamp, to: Infinity }]);
      behaviors.add(subject);
    }
  }
  return found;
}

/** For how long before `stamp` the last of `spells` was over, s; null: one goes on, or none was known. */
export function idleFor(spells: readonly Spell[], stamp: number): number | null {
  const last = spells.findLast(({ from }) => from <= stamp);
  return last && last.to <= stamp ? stamp - last.to : null;
}

/** What an intention was worth and used, from `stamp` until the next. */
export interface IntentionStep {
  stamp: number;
  omega: number;
  use: Readonly<Record<string, number>>;
  strategies: readonly string[];
  proven: boolean;
}

export function intentionSteps(events: readonly RobotEvent[]): IntentionStep[] {
  return events.flatMap(({ kind, stamp, data }) =>
    kind === "intention" && typeof data["omega"] === "number"
      ? [
          {
            stamp,
            omega: data["omega"],
            use: (data["use"] ?? {}) as Record<string, number>,
            strategies: (data["strategies"] ?? []) as string[],
            proven: data["proven"] === true,
          },
        ]
      : [],
  );
}

/** The intention in force at `stamp`; null: not known. */
export function intentionAt(steps: readonly IntentionStep[], stamp: number): IntentionStep | null {
  return steps.findLast((step) => step.stamp <= stamp) ?? null;
}

/** Events of one kind and subject that follow each other closely: one mark. */
export interface Folded {
  kind: string;
  subject: string;
  from: number;
  to: number;
  count: number;
  text: string;
}

/** The `events` folded, where no more than `apart` seconds lie between two of the same kind and subject. */
export function folded(events: readonly RobotEvent[], apart: number): Folded[] {
  const found: Folded[] = [];
  const last = new Map<string, Folded>();
  for (const { kind, subject, stamp, text } of events) {
    const key = `${kind} ${subject}`;
    const before = last.get(key);
    if (before && stamp - before.to <= apart) {
      Object.assign(before, { to: stamp, count: before.count + 1, text });
      continue;
    }
    const mark = { kind, subject, from: stamp, to: stamp, count: 1, text };
    last.set(key, mark);
    found.push(mark);
  }
  return found;
}

/** "imv stale 12×", "guard: driving": of the guard, the state is the event's subject. */
export function foldedWords({ kind, subject, count }: Folded): string {
  const both = kind === "guard" ? `guard: ${subject}` : `${subject} ${kind}`;
  const words = langOf(both) === undefined ? fromRobot(both) : `${named(subject)} ${named(kind)}`;
  return `${words.replaceAll("_", " ")}${count > 1 ? ` ${count}×` : ""}`;
}
