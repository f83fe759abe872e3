/** One resource that attention shares out: how much is promised, of how much; its budget can be changed here. */

import { useSignal } from "@preact/signals";
import { Problem } from "../protocol/rest";
import type { Intention } from "../protocol/types";
import { useApp } from "../state/context";
import { number } from "../ui/format";
import { Meter } from "../ui/Meter";

interface Props {
  name: string;
  label: string;
  use: Intention["use"][string];
}

export function Budget({ name, label, use }: Props) {
  const { session, store } = useApp();
  const open = useSignal(false);
  const text = useSignal("");
  const declared = useSignal<number | null>(null);
  const problem = useSignal("");
  const edit = async () => {
    open.value = !open.value;
    text.value = number(use.capacity, 2);
    problem.value = "";
    if (open.value) declared.value = await session.rest.declaredBudget(name).catch(() => null);
  };
  const set = async (capacity: number) => {
    problem.value = "";
    if (!Number.isFinite(capacity) || capacity < 0) {
      problem.value = `A number from 0 on, in ${use.unit}.`;
      return;
    }
    try {
      await session.rest.changeBudget(name, capacity);
      open.value = false;
      store.notify("info", `The budget is ${number(capacity, 2)} ${use.unit} now.`);
    } catch (error) {
      problem.value = error instanceof Problem ? error.detail || error.title : String(error);
    }
  };
  return (
    <div class="budget" data-testid={`budget-${name}`} data-capacity={use.capacity}>
      <Meter
        label={label}
        value={use.used}
        limit={use.capacity}
        text={`${number(use.used)} of ${number(use.capacity)} ${use.unit}`}
      />
      {!store.replay.value && (
        <button
          type="button"
          class="link-button"
          aria-expanded={open.value}
          data-testid={`budget-edit-${name}`}
          aria-label={`Change the budget: ${label}`}
          onClick={() => void edit()}
        >
          Change
        </button>
      )}
      {open.value && (
        <form
          class="budget-form"
          onSubmit={(event) => {
            event.preventDefault();
            void set(Number(text.value.replace(",", ".")));
          }}
        >
          <label>
            Budget
            <input
              inputMode="decimal"
              autocomplete="off"
              size={6}
              data-testid={`budget-field-${name}`}
              value={text.value}
              aria-invalid={problem.value !== ""}
              onInput={(event) => (text.value = event.currentTarget.value)}
            />
            {use.unit}
          </label>
          <button type="submit" class="button small accent" data-testid={`budget-set-${name}`}>
            Set
          </button>
          {declared.value !== null && declared.value !== use.capacity && (
            <button type="button" class="button small" onClick={() => void set(declared.value!)}>
              Back to {number(declared.value)}
            </button>
          )}
          {problem.value && (
            <p class="inline-note error" role="alert">
              {problem.value}
            </p>
          )}
        </form>
      )}
    </div>
  );
}
