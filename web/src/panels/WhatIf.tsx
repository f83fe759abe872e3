/** What attention would choose with other budgets, desires and costs: sliders, loaded when they are asked for. */

import { useSignal } from "@preact/signals";
import { t } from "../i18n";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { later } from "../ui/later";
import { panel } from "./panel";

export const whatIfPanel = panel({ type: "intention", tab: "Attention", Card: WhatIf, offered: () => true });

const Sliders = later(async () => (await import("./WhatIfSliders")).WhatIfSliders);

function WhatIf({ message }: { message: Message<"intention"> | null }) {
  const { store } = useApp();
  const open = useSignal(false);
  if (store.replay.value || store.role.value === "spectator" || message === null) return null;
  return (
    <section class="card" aria-label={t("What if")} data-testid="what-if">
      <div class="card-head">
        <h2>{t("What if")}</h2>
        <button
          type="button"
          class="link-button"
          aria-expanded={open.value}
          data-testid="what-if-open"
          onClick={() => (open.value = !open.value)}
        >
          {open.value ? t("Close") : t("Try it out")}
        </button>
      </div>
      {open.value ? (
        <Sliders now={message} />
      ) : (
        <p class="muted small">{t("See what the robot would attend to with other budgets, desires or costs.")}</p>
      )}
    </section>
  );
}
