/** A poster that was clicked on the map while a tour is edited: makes a stop of it. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { CloseIcon, PlusIcon } from "../ui/icons";

export function PosterPicked() {
  const { stops, tours } = useApp();
  const poster = stops.picked.value;
  if (!poster || !tours.draft.value) return null;
  const lack = stops.lack(poster);
  return (
    <section class="tour-picked" aria-label={t("Poster")} data-testid="poster-picked" data-text={poster.text}>
      <p>
        <b>{poster.text.length > 60 ? `${poster.text.slice(0, 59)}…` : poster.text}</b>
      </p>
      {lack && <p class="muted small">{lack}</p>}
      <span class="form-actions">
        <button
          type="button"
          class="button small accent"
          data-testid="poster-stop"
          disabled={lack !== "" || !tours.allowed.value}
          onClick={() => void stops.fromPoster(poster)}
        >
          <PlusIcon /> {t("Make a stop")}
        </button>
        <button type="button" class="icon-button" aria-label={t("Dismiss")} onClick={() => (stops.picked.value = null)}>
          <CloseIcon />
        </button>
      </span>
    </section>
  );
}
