/** One resource that attention shares out: how much is promised, of how much; its budget can be changed here. */

import { useSignal } from "@preact/signals";
import { named, t } from "../i18n";
import { inWords } from "../protocol/problem";
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
    const offered = number(use.capacity, 2);
    text.value = offered;
    problem.value = "";
    if (!open.value) return;
    const known = await session.rest.budget(name).catch(() => null);
    declared.value = known?.declared ?? null;
    // Pressure may leave less of it than was set. What was typed meanwhile stays.
    if (known !== null && text.value === offered) text.value = number(known.budget, 2);
  };
  const set = async (capacity: number) => {
    problem.value = "";
    if (!Number.isFinite(capacity) || capacity < 0) {
      problem.value = t("A number from 0 on, in {unit}.", { unit: named(use.unit) });
      return;
    }
    try {
      await session.rest.changeBudget(name, capacity);
      open.value = false;
      store.notify(
        "info",
        t("The budget is {capacity} {unit} now.", { capacity: number(capacity, 2), unit: named(use.unit) }),
      );
    } catch (error) {
      problem.value = inWords(error);
    }
  };
  return (
    <div class="budget" data-testid={`budget-${name}`} data-capacity={use.capacity}>
      <Meter
        label={label}
        value={use.used}
        limit={use.capacity}
        text={t("{used} of {capacity} {unit}", {
          used: number(use.used),
          capacity: number(use.capacity),
          unit: named(use.unit),
        })}
      />
      {!store.replay.value && (
        <button
          type="button"
          class="link-button"
          aria-expanded={open.value}
          data-testid={`budget-edit-${name}`}
          aria-label={t("Change the budget: {label}", { label })}
          onClick={() => void edit()}
        >
          {t("Change")}
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
            {t("Budget")}
            <input
              inputMode="decimal"
              autocomplete="off"
              size={6}
              data-testid={`budget-field-${name}`}
              value={text.value}
              aria-invalid={problem.value !== ""}
              onInput={(event) => (text.value = event.currentTarget.value)}
            />
            {named(use.unit)}
          </label>
          <button type="submit" class="button small accent" data-testid={`budget-set-${name}`}>
            {t("Set")}
          </button>
          {declared.value !== null && declared.value !== use.capacity && (
            <button type="button" class="button small" onClick={() => void set(declared.value!)}>
              {t("Back to {value}", { value: number(declared.value) })}
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
