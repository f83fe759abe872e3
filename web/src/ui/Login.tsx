/** Asks for a password or the token where the console wants one. */

import { useSignal } from "@preact/signals";
import { t } from "../i18n";
import { LanguageChoice } from "../i18n/LanguageChoice";
import { inWords } from "../protocol/problem";
import { useApp } from "../state/context";

export function Login() {
  const { session } = useApp();
  const token = useSignal("");
  const problem = useSignal("");
  const busy = useSignal(false);
  const submit = async (event: Event) => {
    event.preventDefault();
    if (token.value.trim() === "") {
      problem.value = t("A password or the token is needed.");
      return;
    }
    busy.value = true;
    problem.value = "";
    try {
      await session.logIn(token.value.trim());
    } catch (error) {
      problem.value = inWords(error);
    } finally {
      busy.value = false;
    }
  };
  return (
    <main class="login">
      <form class="panel" noValidate onSubmit={(event) => void submit(event)} data-testid="login">
        <h1>{t("HBBA console")}</h1>
        <p class="muted">
          {t("Enter your password, or the robot's token, which the program printed when it started.")}
        </p>
        <div class={`field ${problem.value ? "wrong" : ""}`}>
          <label for="token">{t("Password or token")}</label>
          <input
            id="token"
            type="password"
            autocomplete="current-password"
            data-testid="login-token"
            aria-invalid={!!problem.value}
            aria-describedby="token-problem"
            value={token.value}
            onInput={(event) => (token.value = event.currentTarget.value)}
          />
          <p id="token-problem" class="field-error" role="alert" data-testid="login-problem">
            {problem.value}
          </p>
        </div>
        <button type="submit" class="button accent wide" data-testid="login-submit" disabled={busy.value}>
          {busy.value ? t("Logging in…") : t("Log in")}
        </button>
        <LanguageChoice />
      </form>
    </main>
  );
}
