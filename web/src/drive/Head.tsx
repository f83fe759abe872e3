/** Turning the head by hand: its stick, and what the head does where that is not what was commanded. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { headWords } from "./driveText";
import { HeadStick } from "./Stick";

/** The group of joints that hands turn. */
const GROUP = "head";

export function Head() {
  const { drive, store } = useApp();
  const words = useHeadWords();
  if (!store.body.value.turnsHead) return null;
  return (
    <div class="head-control">
      <HeadStick drive={drive} words={words.text} />
      <span class="head-label" aria-hidden="true">
        {t("Head")}
      </span>
    </div>
  );
}

export function HeadHint() {
  const { text, warns } = useHeadWords();
  if (!text) return null;
  return (
    <p
      class={`drive-hint head-hint ${warns ? "warn" : ""}`}
      data-testid="head-state"
      role={warns ? "status" : undefined}
    >
      {text}
    </p>
  );
}

function useHeadWords() {
  const { drive, store } = useApp();
  const groups = (store.live.value && store.of("status").value?.groups) || [];
  const head = groups.find(({ group }) => group === GROUP) ?? null;
  return headWords(head, drive.state.value.command.head_held);
}
