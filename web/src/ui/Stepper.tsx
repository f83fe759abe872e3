/** A slider with its figure: follows the robot's value unless a hand is on it, and reports when the hand settles. */

import { useSignal } from "@preact/signals";
import { useEffect, useId, useRef } from "preact/hooks";
import { number } from "./format";

const SETTLE_MS = 250;
const STEP = 0.5;

interface Props {
  label: string;
  value: number;
  limit: number;
  /** Zero is a value of its own (utility); else the least is one step. */
  tone: "intensity" | "utility";
  /** What a value of zero means, if it means something of its own. */
  zero?: string;
  /** Resolves to false if the robot refused. */
  onChange(value: number): Promise<boolean>;
}

export function Stepper({ label, value, limit, tone, zero, onChange }: Props) {
  const id = useId();
  const shown = useSignal(value);
  const timer = useRef(0);
  const newest = useRef(value);
  newest.current = value;
  useEffect(() => {
    if (!timer.current) shown.value = value;
  }, [value]);
  useEffect(() => () => clearTimeout(timer.current), []);

  const settle = (next: number) => {
    shown.value = next;
    clearTimeout(timer.current);
    timer.current = window.setTimeout(() => {
      timer.current = 0;
      void onChange(next).then((taken) => {
        if (!taken && !timer.current) shown.value = newest.current;
      });
    }, SETTLE_MS);
  };
  return (
    <div class={`stepper ${tone}`}>
      <label for={id}>{label}</label>
      <input
        id={id}
        type="range"
        min={zero ? 0 : STEP}
        max={limit}
        step={STEP}
        value={shown.value}
        style={{ "--fill": `${(100 * (shown.value - (zero ? 0 : STEP))) / (limit - (zero ? 0 : STEP))}%` }}
        onInput={(event) => settle(Number(event.currentTarget.value))}
      />
      <output for={id}>{shown.value === 0 && zero ? zero : number(shown.value)}</output>
    </div>
  );
}
