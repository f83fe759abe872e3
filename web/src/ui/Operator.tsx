/** The operator's name, as the robot and other pages see it. Kept in this browser. */

import { useSignal } from "@preact/signals";
import { useApp } from "../state/context";

export function Operator() {
  const { store } = useApp();
  const editing = useSignal(false);
  if (!editing.value) {
    return (
      <button
        type="button"
        class="operator"
        data-testid="operator"
        title="Your name, as others see it. Click to change."
        onClick={() => (editing.value = true)}
      >
        {store.operator.value}
      </button>
    );
  }
  const done = (value: string) => {
    editing.value = false;
    if (value.trim() !== store.operator.peek()) store.rename(value);
  };
  return (
    <input
      class="operator"
      data-testid="operator-name"
      aria-label="Your name"
      maxLength={40}
      defaultValue={store.operator.value}
      ref={(input) => input?.focus()}
      onBlur={(event) => done(event.currentTarget.value)}
      onKeyDown={(event) => event.key === "Enter" && done(event.currentTarget.value)}
    />
  );
}
