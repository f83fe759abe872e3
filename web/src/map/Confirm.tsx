/** Asks once more before something is lost. */

import { t } from "../i18n";

export function Confirm(props: { words: string; yes: string; no?: string; onYes: () => void; onNo: () => void }) {
  return (
    <div class="recording-confirm" role="group" aria-label={props.words}>
      <span>{props.words}</span>
      <button type="button" class="button small danger" data-testid="map-confirm" onClick={props.onYes}>
        {props.yes}
      </button>
      <button type="button" class="button small" data-testid="map-keep" ref={focused} onClick={props.onNo}>
        {props.no ?? t("Keep")}
      </button>
    </div>
  );
}

function focused(button: HTMLButtonElement | null): void {
  button?.focus();
}
