/** Sliders for budgets, desires and costs: what attention would choose, while the robot goes on as it is. */

import { useSignal } from "@preact/signals";
import { useEffect, useId, useRef } from "preact/hooks";
import { named, t } from "../i18n";
import { inWords } from "../protocol/problem";
import { idempotencyKey } from "../protocol/requests";
import type { Intention } from "../protocol/types";
import { useApp } from "../state/context";
import { number, spaced } from "../ui/format";
import { Meter } from "../ui/Meter";
import { NewestAnswer } from "./newestAnswer";
import { resourceLabel, resourceUnit } from "./resourceNames";
import {
  bodyOf,
  type Deed,
  dearest,
  deedsOf,
  deedWords,
  differences,
  isNothing,
  NOTHING,
  outcome,
  type Supposed,
  supposedHeadline,
  withCost,
  withValue,
} from "./supposition";

/** Sliders go to so many times what there is. */
const MOST_TIMES = 2;
const STEPS = 200;

export function WhatIfSliders({ now }: { now: Intention }) {
  const { store } = useApp();
  const supposed = useSignal<Supposed>(NOTHING);
  const { then, problem, forget } = useAnswer(supposed.value, now);
  const scale = store.hello.value?.scale.intensity ?? 8;
  const classes = [...new Set([...Object.keys(now.asked), ...Object.keys(supposed.value.desires)])].sort();
  const others = (store.hello.value?.classes ?? []).filter(({ name, served }) => served && !classes.includes(name));
  const reset = () => {
    forget();
    supposed.value = NOTHING;
  };
  return (
    <div class="what-if">
      <div class="what-if-said">
        <p class="attention-headline" aria-live="polite" data-testid="what-if-headline" data-omega={then?.omega ?? ""}>
          {problem ? "" : then ? supposedHeadline(then.reasons) : t("Everything as it is now: move a slider.")}
        </p>
        {problem && <p class="inline-note error">{problem}</p>}
        {isNothing(supposed.value) ? (
          <p class="muted small">{t("Nothing here touches the robot until you apply it.")}</p>
        ) : (
          <Apply supposed={supposed.value} now={now} onDone={reset} />
        )}
      </div>
      <fieldset>
        <legend>{t("Budgets")}</legend>
        {Object.entries(now.use).map(([name, { capacity, unit }]) => (
          <Slider
            key={name}
            id={`capacity-${name}`}
            label={resourceLabel(name)}
            value={supposed.value.capacities[name] ?? capacity}
            now={capacity}
            most={MOST_TIMES * capacity || 100}
            note={then ? `→ ${number(then.use[name]?.used)}` : ""}
            words={(value) => `${number(value)} ${named(unit)}`}
            onChange={(value) => {
              supposed.value = withValue(supposed.value, "capacities", name, value, capacity);
            }}
          />
        ))}
      </fieldset>
      <fieldset>
        <legend>{t("Desires, by intensity")}</legend>
        {classes.map((name) => (
          <Slider
            key={name}
            id={`desire-${name}`}
            label={spaced(name)}
            value={supposed.value.desires[name] ?? now.asked[name]?.intensity ?? 0}
            now={now.asked[name]?.intensity ?? 0}
            most={scale}
            steps={2 * scale}
            note={then ? outcome(now, then, name) : ""}
            words={(value) => (value === 0 ? t("not desired") : number(value))}
            onChange={(value) => {
              supposed.value = withValue(supposed.value, "desires", name, value, now.asked[name]?.intensity ?? 0);
            }}
          />
        ))}
        {others.length > 0 && (
          <select
            aria-label={t("Suppose another desire")}
            data-testid="what-if-add"
            value=""
            onChange={(event) => {
              const name = event.currentTarget.value;
              if (name) supposed.value = withValue(supposed.value, "desires", name, scale / 2, 0);
            }}
          >
            <option value="">{t("Suppose another desire…")}</option>
            {others.map(({ name }) => (
              <option key={name} value={name}>
                {spaced(name)}
              </option>
            ))}
          </select>
        )}
      </fieldset>
      <Costs now={now} then={then} supposed={supposed.value} onChange={(next) => (supposed.value = next)} />
      <div class="what-if-answer" data-testid="what-if-answer">
        {!problem && then && <Answer now={now} then={then} />}
      </div>
    </div>
  );
}

/** What strategies that are selected, or would be, cost: each by the resource it needs most. */
function Costs(props: { now: Intention; then: Intention | null; supposed: Supposed; onChange(next: Supposed): void }) {
  const { now, then, supposed, onChange } = props;
  const real = useRef(new Map<string, Readonly<Record<string, number>>>());
  for (const { name, costs } of now.strategies) real.current.set(name, costs);
  for (const { name, costs } of then?.strategies ?? [])
    if (!real.current.has(name) && !supposed.costs[name]) real.current.set(name, costs);
  const shown = [...real.current].flatMap(([name, costs]) => {
    const resource = dearest(costs, now.use);
    return resource ? [{ name, resource, cost: costs[resource]! }] : [];
  });
  if (shown.length === 0) return null;
  return (
    <details class="what-if-costs" data-testid="what-if-costs">
      <summary>{t("Costs of strategies")}</summary>
      {shown.map(({ name, resource, cost }) => (
        <Slider
          key={name}
          id={`cost-${name}`}
          label={name}
          value={supposed.costs[name]?.[resource] ?? cost}
          now={cost}
          most={3 * cost}
          words={(value) => `${number(value)} ${resourceUnit(resource)}`}
          onChange={(value) => onChange(withCost(supposed, name, resource, value, cost))}
        />
      ))}
    </details>
  );
}

function Answer({ now, then }: { now: Intention; then: Intention }) {
  const changed = differences(now, then);
  return (
    <>
      <h3>{t("What would change")}</h3>
      {changed.length === 0 ? (
        <p class="muted small">{t("Nothing would change.")}</p>
      ) : (
        <ul class="what-if-changes">
          {changed.map(({ name, before, after, better }) => (
            <li key={name} class={better ? "better" : "worse"} data-testid={`what-if-${name}`}>
              <b>{spaced(name)}</b>
              <span class="muted">{before}</span>
              <span>
                <span aria-hidden="true">→ </span>
                {after}
              </span>
            </li>
          ))}
        </ul>
      )}
      <div class="resources">
        {Object.entries(then.use).map(([name, { used, capacity, unit }]) => (
          <Meter
            key={name}
            label={resourceLabel(name)}
            value={used}
            limit={capacity}
            text={t("{used} of {capacity} {unit}", {
              used: number(used),
              capacity: number(capacity),
              unit: named(unit),
            })}
          />
        ))}
      </div>
      <p class="muted small">
        {t("Ω = {omega}, now {now}", { omega: number(then.omega, 2), now: number(now.omega, 2) })}
      </p>
    </>
  );
}

/** What is supposed is set for good: asked for, and once more confirmed. */
function Apply({ supposed, now, onDone }: { supposed: Supposed; now: Intention; onDone(): void }) {
  const { session, store } = useApp();
  const asks = useSignal(false);
  const problem = useSignal("");
  const deeds = deedsOf(supposed, now);
  const perform = async ({ kind, name, value }: Deed) => {
    if (kind === "capacity") await session.rest.changeBudget(name, value);
    else if (kind === "remove") await session.rest.removeDesire(now.desires[name]!);
    else if (kind === "intensity") await session.rest.changeDesire(now.desires[name]!, { intensity: value });
    else await session.rest.addDesire({ class: name, intensity: value, utility: 1 }, idempotencyKey());
  };
  const apply = async () => {
    problem.value = "";
    try {
      for (const deed of deeds) await perform(deed);
      store.notify("info", t("Applied: the robot attends accordingly."));
      onDone();
    } catch (error) {
      problem.value = inWords(error);
    }
  };
  return (
    <div class="what-if-apply">
      {asks.value && (
        <ul class="small" data-testid="what-if-deeds">
          {deeds.map((deed) => (
            <li key={`${deed.kind} ${deed.name}`}>
              {deedWords(deed, resourceLabel(deed.name), named(now.use[deed.name]?.unit ?? ""))}
            </li>
          ))}
        </ul>
      )}
      {Object.keys(supposed.costs).length > 0 && (
        <p class="muted small">{t("Costs are what was measured: they are not applied.")}</p>
      )}
      <span class="form-actions">
        <button type="button" class="button small" data-testid="what-if-reset" onClick={onDone}>
          {t("Back to now")}
        </button>
        {deeds.length > 0 &&
          (asks.value ? (
            <button
              type="button"
              class="button small accent"
              data-testid="what-if-confirm"
              onClick={() => void apply()}
            >
              {t("Yes, set this")}
            </button>
          ) : (
            <button type="button" class="button small" data-testid="what-if-apply" onClick={() => (asks.value = true)}>
              {t("Apply…")}
            </button>
          ))}
      </span>
      {problem.value && (
        <p class="inline-note error" role="alert">
          {problem.value}
        </p>
      )}
    </div>
  );
}

interface SliderProps {
  id: string;
  label: string;
  /** What would come of it. */
  note?: string;
  value: number;
  /** What there is; its place is marked once the value is another. */
  now: number;
  most: number;
  steps?: number;
  words(value: number): string;
  onChange(value: number): void;
}

function Slider({ id, label, note = "", value, now, most, steps = STEPS, words, onChange }: SliderProps) {
  const own = useId();
  const step = most / steps;
  const near = Math.abs(value - now) < step / 2;
  return (
    <div class={`what-if-slider ${near ? "" : "changed"}`} style={{ "--now": now / most }}>
      <label for={own}>{label}</label>
      <span class="what-if-note">{note}</span>
      <output for={own}>{words(value)}</output>
      <input
        id={own}
        type="range"
        min={0}
        max={most}
        step={step}
        value={value}
        data-testid={`what-if-${id}`}
        aria-valuetext={words(value)}
        onInput={(event) => {
          const asked = event.currentTarget.valueAsNumber;
          onChange(Math.abs(asked - now) < step / 2 ? now : Math.round(asked * 1000) / 1000);
        }}
      />
    </div>
  );
}

/** The answer to `supposed`; null while nothing is supposed. A new intention of the robot asks again. */
function useAnswer(supposed: Supposed, now: Intention) {
  const { session } = useApp();
  const then = useSignal<Intention | null>(null);
  const problem = useSignal("");
  const asker = useRef<NewestAnswer<Parameters<typeof session.rest.whatIf>[0], Intention> | null>(null);
  asker.current ??= new NewestAnswer(
    (body) => session.rest.whatIf(body),
    (answer) => {
      then.value = answer;
      problem.value = "";
    },
    (error) => {
      problem.value = inWords(error);
    },
  );
  const forget = () => {
    asker.current!.forget();
    then.value = null;
    problem.value = "";
  };
  useEffect(() => {
    if (isNothing(supposed)) forget();
    else asker.current!.ask(bodyOf(supposed, now));
  }, [supposed, now]);
  useEffect(() => () => asker.current!.forget(), []);
  return { then: then.value, problem: problem.value, forget };
}
