/** Asks for a person's name at the first use of this browser, so that others see who drives. */

import { useSignal } from "@preact/signals";
import { t } from "../i18n";
import { useApp } from "../state/context";

export function NameAsk() {
  const { store, session } = useApp();
  const name = useSignal("");
  // What a person has opened comes first.
  if (store.named.value || !store.hello.value || store.replay.value || store.help.value) return null;
  const done = (event: Event) => {
    event.preventDefault();
    session.rename(name.value);
  };
  return (
    <form class="name-ask" data-testid="name-ask" aria-label={t("Your name")} onSubmit={done}>
      <label for="name-ask">{t("Your name, for others to see who drives")}</label>
      <div class="name-ask-row">
        <input
          id="name-ask"
          maxLength={40}
          autocomplete="nickname"
          data-testid="name-ask-input"
          value={name.value}
          onInput={(event) => (name.value = event.currentTarget.value)}
        />
        <button type="submit" class="button accent" data-testid="name-ask-done">
          {name.value.trim() ? t("Done") : t("Stay “operator”")}
        </button>
      </div>
    </form>
  );
}
