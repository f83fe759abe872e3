/** An instant that was clicked: the whole intention of then, with what it cost and why, until it is closed. */

import { useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect } from "preact/hooks";
import { langOf, named, t } from "../i18n";
import type { StrategyReport } from "../protocol/types";
import { useApp } from "../state/context";
import { clockTime, number, reasonText, spaced, stateWord } from "../ui/format";
import { CloseIcon, StateMark } from "../ui/icons";
import type { LaneSample } from "./history";
import type { IntentionStep } from "./timelineOf";

export interface Pin {
  stamp: number;
  intention: IntentionStep | null;
  /** What each lane showed. */
  samples: { name: string; sample: LaneSample; exploited: boolean }[];
}

export function Pinned({ pin, close }: { pin: Pin; close: () => void }) {
  const { session, store } = useApp();
  const strategies = useSignal<readonly StrategyReport[]>([]);
  useEffect(() => {
    session.rest.strategies().then(
      (list) => (strategies.value = list),
      () => undefined, // their names are shown all the same
    );
  }, []);
  useLayoutEffect(() => store.opened(close), []);
  const use = Object.entries(pin.intention?.use ?? {});
  const unit = (name: string) => named(store.of("intention").value?.use[name]?.unit ?? "");
  const costs = (name: string) => strategies.value.find((strategy) => strategy.name === name);
  const selected = (cls: string) =>
    (pin.intention?.strategies ?? []).map(costs).filter((strategy) => strategy?.class === cls) as StrategyReport[];
  return (
    <aside class="lane-pin" aria-label={t("Intention at the pinned instant")} data-testid="lane-pin">
      <header>
        <h2>{clockTime(pin.stamp)}</h2>
        {pin.intention && (
          <span>
            Ω {number(pin.intention.omega)}
            {pin.intention.proven && t(", proven")}
          </span>
        )}
        <button type="button" class="icon-button" aria-label={t("Close the pinned instant")} onClick={close}>
          <CloseIcon />
        </button>
      </header>
      {!pin.intention && <p class="muted">{t("The intention of then is not known; the reasons are.")}</p>}
      {use.length > 0 && (
        <dl class="lane-pin-use">
          {use.map(([name, used]) => (
            <div key={name}>
              <dt>{name.length <= 3 ? name.toUpperCase() : spaced(name)}</dt>
              <dd>
                {number(used)} {unit(name)}
              </dd>
            </div>
          ))}
        </dl>
      )}
      <ul>
        {pin.samples.map(({ name, sample, exploited }) => (
          <li key={name}>
            <p class="lane-pin-class">
              <StateMark state={sample.state} />
              <b>{spaced(name)}</b>
              <span>
                {t("intensity {intensity}, utility {utility}", {
                  intensity: number(sample.intensity),
                  utility: number(sample.utility),
                })}
              </span>
            </p>
            <p>
              <b class="state-word">{stateWord(sample.state)}</b>
              {exploited && t(", exploited")}.{" "}
              <span lang={langOf(sample.text)}>{reasonText(sample.state, sample.text)}</span>
            </p>
            {selected(name).map((strategy) => (
              <p key={strategy.name} class="muted">
                {strategy.name}: {t("utility {utility}", { utility: number(strategy.utility) })}
                {Object.entries(strategy.costs).map(
                  ([cost, value]) => `, ${number(value)} ${unit(cost)} ${named(cost)}`,
                )}
              </p>
            ))}
          </li>
        ))}
      </ul>
    </aside>
  );
}
