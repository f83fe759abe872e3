/** The operator's name, as the robot and other pages see it. Kept in this browser. */

import { useSignal } from "@preact/signals";
import { t } from "../i18n";
import { useApp } from "../state/context";

const ROLES = {
  spectator: "You see everything and can stop the robot. You change nothing else.",
  operator: "You drive and edit.",
  supervisor: "You may do everything.",
} as const;

export function Operator() {
  const { store, session } = useApp();
  const editing = useSignal(false);
  if (!editing.value) {
    return (
      <span class="operator-group">
        {store.hello.value && store.role.value !== "supervisor" && (
          <span class="chip role" data-testid="role" title={t(ROLES[store.role.value])}>
            {store.role.value === "spectator" ? t("Spectator") : t("Operator")}
          </span>
        )}
        <button
          type="button"
          class="operator"
          data-testid="operator"
          title={t("Your name, as others see it. Click to change.")}
          onClick={() => (editing.value = true)}
        >
          {store.operator.value}
        </button>
        {store.loggedIn.value && (
          <button type="button" class="button small quiet" data-testid="log-out" onClick={() => void session.logOut()}>
            {t("Log out")}
          </button>
        )}
      </span>
    );
  }
  const done = (value: string) => {
    editing.value = false;
    if (value.trim() !== store.operator.peek()) session.rename(value);
  };
  return (
    <input
      class="operator"
      data-testid="operator-name"
      aria-label={t("Your name")}
      maxLength={40}
      defaultValue={store.operator.value}
      ref={(input) => input?.focus()}
      onBlur={(event) => done(event.currentTarget.value)}
      onKeyDown={(event) => event.key === "Enter" && done(event.currentTarget.value)}
    />
  );
}
