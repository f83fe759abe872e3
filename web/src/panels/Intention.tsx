/** What the robot gave up and why, first; then what it attends to in full. Names, filters and costs on demand. */

import { signal } from "@preact/signals";
import { langOf, t } from "../i18n";
import type { Intention as IntentionMessage, SelectedStrategy } from "../protocol/types";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { ago, divisor, number, reasonText, small, spaced, stateWord } from "../ui/format";
import { StateMark, WarnIcon } from "../ui/icons";
import { headline, intake, plainReason, type Reason, shortfall, sorted } from "./attentionText";
import { Budget } from "./Budget";
import { panel } from "./panel";
import { resourceLabel, resourceUnit } from "./resourceNames";

export const intentionPanel = panel({ type: "intention", tab: "Attention", Card: Intention, offered: () => true });

/** Whether strategies, filters and costs are shown by their names. */
const named = signal(false);

function Intention({ message }: { message: Message<"intention"> | null }) {
  return (
    <section class="card" aria-label={t("Intention")} data-testid="intention">
      <div class="card-head">
        <h2>{t("What the robot attends to, and why")}</h2>
        {message && (
          <button
            type="button"
            class="link-button"
            aria-pressed={named.value}
            data-testid="intention-names"
            title={t("Strategies, filters and costs by their names in the program")}
            onClick={() => (named.value = !named.value)}
          >
            {named.value ? t("Plain words") : t("Names")}
          </button>
        )}
      </div>
      {message ? <Body intention={message} /> : <p class="empty">{t("No intention yet.")}</p>}
    </section>
  );
}

function Body({ intention }: { intention: IntentionMessage }) {
  const { given, best } = sorted(intention.reasons);
  const serving = (name: string) => intention.strategies.filter((strategy) => strategy.class === name);
  const others = intention.strategies.filter((strategy) => !(strategy.class in intention.reasons));
  return (
    <>
      <p class="attention-headline" data-testid="attention-headline">
        {headline(intention.reasons)}
      </p>
      <ul class="reasons">
        {given.map(([name, reason]) => (
          <Row key={name} name={name} reason={reason} strategies={serving(name)} />
        ))}
      </ul>
      {intention.relaxed.length > 0 && (
        <p class="inline-note warn">
          <WarnIcon />
          <span>
            {t("Security desires that could not all be met: {classes}.", {
              classes: intention.relaxed.map(spaced).join(", "),
            })}
          </span>
        </p>
      )}
      {best.length + others.length > 0 && (
        <details class="attention-best" open={named.value} data-testid="attention-best">
          <summary>
            {given.length > 0 && t("In full: ")}
            {[...best.map(([name]) => name), ...others.map((strategy) => strategy.class)].map(spaced).join(", ")}
          </summary>
          <ul class="reasons">
            {best.map(([name, reason]) => (
              <Row key={name} name={name} reason={reason} strategies={serving(name)} />
            ))}
            {others.map((strategy) => (
              <li key={strategy.name} class="reason needed">
                <StateMark state="needed" />
                <div>
                  <p class="reason-head">
                    <b>{spaced(strategy.class)}</b>
                    <span class="state-word">{t("needed by another")}</span>
                  </p>
                  <Taken strategies={[strategy]} />
                </div>
              </li>
            ))}
          </ul>
        </details>
      )}
      <div class="resources">
        {Object.entries(intention.use).map(([name, use]) => (
          <Budget key={name} name={name} label={resourceLabel(name)} use={use} />
        ))}
      </div>
      <p
        class="muted small"
        data-testid="omega"
        data-omega={intention.omega}
        title={t("Ω, the worth of what was chosen (the higher, the more of what is desired is served)")}
      >
        <ChosenAgo stamp={intention.stamp} />
        {intention.proven ? t("No better choice exists") : t("The best choice found; a better one may exist")}
        {named.value &&
          ` · ${t("Ω = {omega} in {time} ms", { omega: number(intention.omega, 2), time: number(intention.solve_ms, 1) })}`}
      </p>
    </>
  );
}

/** "Chosen 12 s ago", and a dot to what follows. */
function ChosenAgo({ stamp }: { stamp: number }) {
  const { store } = useApp();
  const now = store.seconds.value;
  return now === null ? null : <>{t("Chosen {ago}", { ago: ago(now - stamp) })} · </>;
}

function Row({ name, reason, strategies }: { name: string; reason: Reason; strategies: SelectedStrategy[] }) {
  const why = named.value ? reason.text : reason.state === "fulfilled" ? "" : plainReason(reason);
  return (
    <li class={`reason ${reason.state}`} data-testid={`reason-${name}`} data-state={reason.state}>
      <StateMark state={reason.state} />
      <div>
        <p class="reason-head">
          <b>{spaced(name)}</b>
          <span class="state-word">{shortfall(reason) || stateWord(reason.state)}</span>
          {named.value && (
            <span class="muted">
              {t("utility {utility}, {wanted} wanted", {
                utility: number(reason.utility),
                wanted: number(reason.wanted),
              })}
            </span>
          )}
        </p>
        {why && (
          <p class="reason-text" lang={langOf(why)}>
            {reasonText(reason.state, why)}
          </p>
        )}
        <Taken strategies={strategies} />
      </div>
    </li>
  );
}

/** What strategies take in and cost: in plain words, or by their names. */
function Taken({ strategies }: { strategies: SelectedStrategy[] }) {
  if (named.value) return strategies.map((strategy) => <Strategy key={strategy.name} strategy={strategy} />);
  const words = intake(strategies);
  return words.length > 0 ? <p class="intake">{words.join(" · ")}</p> : null;
}

function Strategy({ strategy }: { strategy: SelectedStrategy }) {
  const filters = Object.entries(strategy.filters);
  return (
    <p class="strategy" data-testid={`strategy-${strategy.name}`}>
      <span class="strategy-name">{strategy.name}</span>
      {filters.map(([port, phi]) => (
        <span key={port} class="filter" data-filter={port} data-divisor={phi ?? ""} title={t("φ of {port}", { port })}>
          {port} <b>{divisor(phi)}</b>
        </span>
      ))}
      {Object.entries(strategy.costs)
        .filter(([, cost]) => cost > 0)
        .map(([resource, cost]) => (
          <span key={resource} class="cost">
            {small(cost)} {resourceUnit(resource)}
          </span>
        ))}
    </p>
  );
}
