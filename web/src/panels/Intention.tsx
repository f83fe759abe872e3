/** What the robot attends to and why: the intention, class by class, its filters and what it costs. */

import type { Intention as IntentionMessage, SelectedStrategy } from "../protocol/types";
import type { Message } from "../state/latest";
import { divisor, number, reasonText, small, spaced, stateWord } from "../ui/format";
import { StateMark, WarnIcon } from "../ui/icons";
import { Meter } from "../ui/Meter";
import { panel } from "./panel";

export const intentionPanel = panel({ type: "intention", tab: "Attention", Card: Intention, offered: () => true });

function Intention({ message }: { message: Message<"intention"> | null }) {
  return (
    <section class="card" aria-label="Intention" data-testid="intention">
      <h2>What the robot attends to, and why</h2>
      {message ? <Body intention={message} /> : <p class="empty">No intention yet.</p>}
    </section>
  );
}

function Body({ intention }: { intention: IntentionMessage }) {
  const reasons = Object.entries(intention.reasons);
  const serving = (name: string) => intention.strategies.filter((strategy) => strategy.class === name);
  const reasoned = new Set(reasons.map(([name]) => name));
  const others = intention.strategies.filter((strategy) => !reasoned.has(strategy.class));
  return (
    <>
      <div class="resources">
        {Object.entries(intention.use).map(([name, use]) => (
          <Meter
            key={name}
            label={RESOURCES[name]?.label ?? capital(spaced(name))}
            value={use.used}
            limit={use.capacity}
            text={`${number(use.used)} of ${number(use.capacity)} ${use.unit}`}
          />
        ))}
      </div>
      {reasons.length === 0 && <p class="empty">No desires: all filters of attention are closed.</p>}
      <ul class="reasons">
        {reasons.map(([name, reason]) => (
          <li key={name} class={`reason ${reason.state}`} data-testid={`reason-${name}`} data-state={reason.state}>
            <StateMark state={reason.state} />
            <div>
              <p class="reason-head">
                <b>{spaced(name)}</b>
                <span class="state-word">{stateWord(reason.state)}</span>
                {reason.utility !== null && reason.wanted !== null && (
                  <span class="muted">
                    utility {number(reason.utility)}, {number(reason.wanted)} wanted
                  </span>
                )}
              </p>
              <p class="reason-text">{reasonText(reason.state, reason.text)}</p>
              {serving(name).map((strategy) => (
                <Strategy key={strategy.name} strategy={strategy} />
              ))}
            </div>
          </li>
        ))}
        {others.map((strategy) => (
          <li key={strategy.name} class="reason needed">
            <StateMark state="needed" />
            <div>
              <p class="reason-head">
                <b>{spaced(strategy.class)}</b>
                <span class="state-word">needed</span>
              </p>
              <Strategy strategy={strategy} />
            </div>
          </li>
        ))}
      </ul>
      {intention.relaxed.length > 0 && (
        <p class="inline-note warn">
          <WarnIcon />
          <span>Security desires that could not all be met: {intention.relaxed.map(spaced).join(", ")}.</span>
        </p>
      )}
      <p class="muted small" data-testid="omega" data-omega={intention.omega}>
        Ω = {number(intention.omega, 2)} · {intention.proven ? "proven optimal" : "best found, not proven"} in{" "}
        {number(intention.solve_ms, 1)} ms
      </p>
    </>
  );
}

/** The lab's resources in words: the meter's label, and the unit of a strategy's cost. Others go by their names. */
const RESOURCES: Record<string, { label: string; unit: string }> = {
  cpu: { label: "CPU promised", unit: "% CPU" },
  recording: { label: "CPU for recording", unit: "% CPU to record" },
  power: { label: "Power promised", unit: "W" },
};

function capital(words: string): string {
  return words.charAt(0).toUpperCase() + words.slice(1);
}

function Strategy({ strategy }: { strategy: SelectedStrategy }) {
  const filters = Object.entries(strategy.filters);
  return (
    <p class="strategy" data-testid={`strategy-${strategy.name}`}>
      <span class="strategy-name">{strategy.name}</span>
      {filters.map(([port, phi]) => (
        <span key={port} class="filter" data-filter={port} data-divisor={phi ?? ""} title={`φ of ${port}`}>
          {port} <b>{divisor(phi)}</b>
        </span>
      ))}
      {Object.entries(strategy.costs)
        .filter(([, cost]) => cost > 0)
        .map(([resource, cost]) => (
          <span key={resource} class="cost">
            {small(cost)} {RESOURCES[resource]?.unit ?? resource}
          </span>
        ))}
    </p>
  );
}
