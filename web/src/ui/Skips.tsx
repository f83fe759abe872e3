/** Ways past what stands first, for the keyboard: seen while they have the focus. */

import { useApp } from "../state/context";

export function Skips() {
  const { map, store } = useApp();
  const to = (selector: string) => () => document.querySelector<HTMLElement>(selector)?.focus();
  return (
    <nav class="skips" aria-label="Skip to">
      {store.body.value.maps && (
        <button type="button" class="button" data-testid="skip-map" onClick={() => map.call()}>
          To the map <kbd>G</kbd>
        </button>
      )}
      <button type="button" class="button" data-testid="skip-panels" onClick={to("[role=tab][aria-selected=true]")}>
        To the panels
      </button>
      <button type="button" class="button" data-testid="skip-lanes" onClick={to(".lane-area")}>
        To the lanes
      </button>
    </nav>
  );
}
