/** Ways past what stands first, for the keyboard: seen while they have the focus. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { low, narrow } from "./media";

export function Skips() {
  const { map, store } = useApp();
  const to = (selector: string) => () => document.querySelector<HTMLElement>(selector)?.focus();
  const toLanes = () => {
    if (narrow.peek() || low.peek()) store.tab.value = "lanes";
    requestAnimationFrame(to(".lane-area")); // in their tab, they are there with the next frame
  };
  return (
    <nav class="skips" aria-label={t("Skip to")}>
      {store.body.value.maps && (
        <button type="button" class="button" data-testid="skip-map" onClick={() => map.call()}>
          {t("To the map")} <kbd>G</kbd>
        </button>
      )}
      <button type="button" class="button" data-testid="skip-panels" onClick={to("[role=tab][aria-selected=true]")}>
        {t("To the panels")}
      </button>
      <button type="button" class="button" data-testid="skip-lanes" onClick={toLanes}>
        {t("To the lanes")}
      </button>
    </nav>
  );
}
