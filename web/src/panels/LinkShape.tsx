/** The link to the robot made worse on purpose, for tests: what it is now, and a form that changes it. */

import { signal } from "@preact/signals";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { LinkReport } from "../protocol/types";
import { useApp } from "../state/context";

const FIELDS = [
  { name: "delay_ms", label: "Round trip, ms", most: 5000 },
  { name: "jitter_ms", label: "± jitter, ms", most: 5000 },
  { name: "loss_percent", label: "Loss, %", most: 50 },
  { name: "rate_mbit", label: "Rate, Mbit/s", most: 10000 },
] as const;

const problem = signal("");

export function LinkShape({ message: link }: { message: LinkReport | null }) {
  const { session } = useApp();
  const shape = async (change: Record<string, number>) => {
    try {
      await session.rest.shapeLink(change);
      problem.value = "";
    } catch (error) {
      problem.value = inWords(error);
    }
  };
  return (
    <section class="card" aria-label={t("Shaped link")} data-testid="link-shape">
      <h2>{t("Shaped link")}</h2>
      <p class="muted small">
        {link?.shaped
          ? t("Every stream to the pages: {text}.", { text: link.text })
          : t("For tests: every stream between the robot and its pages delayed and bounded, as by a bad network.")}
      </p>
      <form
        key={link?.text}
        class="link-form"
        onSubmit={(event) => {
          event.preventDefault();
          const given = new FormData(event.currentTarget);
          void shape(linkChange((name) => String(given.get(name) ?? "")));
        }}
      >
        <div class="form-row two">
          {FIELDS.map(({ name, label, most }) => (
            <div key={name} class="field">
              <label for={`link-${name}`}>{t(label)}</label>
              <input
                id={`link-${name}`}
                name={name}
                type="number"
                min="0"
                max={most}
                step="any"
                placeholder={name === "rate_mbit" ? t("not bounded") : "0"}
                value={link?.[name] || ""}
              />
            </div>
          ))}
        </div>
        {problem.value && (
          <p class="field-error" role="alert">
            {problem.value}
          </p>
        )}
        <div class="form-actions">
          <button type="submit" class="button" data-testid="link-apply">
            {t("Shape")}
          </button>
          <button type="button" class="button quiet" disabled={!link?.shaped} onClick={() => void shape({})}>
            {t("Off")}
          </button>
        </div>
      </form>
    </section>
  );
}

/** What is filled in; an empty field shapes nothing. */
export function linkChange(field: (name: string) => string): Record<string, number> {
  const filled = FIELDS.map(({ name }) => [name, field(name).trim()] as const).filter(([, text]) => text !== "");
  return Object.fromEntries(filled.map(([name, text]) => [name, Number(text)]));
}
