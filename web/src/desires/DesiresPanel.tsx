/** One more desire, above all else; the desires there are, and those that ended last. */

import { t } from "../i18n";
import { panel } from "../panels/panel";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { DesireList, EndedList } from "./DesireList";
import { DesireQuick } from "./DesireQuick";

/** At the top of the tab: what people come for. */
export const addDesirePanel = panel({ type: "desires", tab: "Attention", Card: AddDesire, offered: () => true });
export const desiresPanel = panel({ type: "desires", tab: "Attention", Card: Desires, offered: () => true });

function Desires({ message }: { message: Message<"desires"> | null }) {
  return (
    <section class="card" aria-label={t("Desires")}>
      <h2>
        {t("Desires")} <span class="count">{message?.desires.length ?? 0}</span>
      </h2>
      <DesireList
        desires={message?.desires ?? null}
        accomplishments={message?.accomplishments ?? []}
        progress={message?.progress ?? []}
      />
      <EndedList ended={message?.ended ?? []} />
    </section>
  );
}

function AddDesire() {
  const { store } = useApp();
  if (store.replay.value) return null;
  return (
    <section class="card" aria-label={t("Add a desire")}>
      <DesireQuick />
    </section>
  );
}
