/** Makes stops: where the robot is, before found posters, at places of the map. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { PlaceIcon, PlusIcon } from "../ui/icons";
import { stopOf } from "./tourEdits";

export function StopAdders() {
  const { places, stops, store, tours } = useApp();
  const tour = tours.draft.value!;
  const posters = (store.of("landmarks").value?.landmarks ?? []).filter((one) => !stopOf(tour, one));
  const free = places.all.value.filter(({ id }) => !tour.stops.some(({ place }) => place === id));
  const known = store.of("localization").value !== null;
  const allowed = tours.allowed.value;
  return (
    <div class="tour-adders" role="group" aria-label={t("Add a stop")}>
      <button
        type="button"
        class="button small"
        data-testid="stop-here"
        title={t("A stop where the robot is now")}
        disabled={!allowed || !known}
        onClick={() => void stops.here()}
      >
        <PlaceIcon /> {t("Here")}
      </button>
      {posters.map((poster) => (
        <button
          key={`${poster.text}@${poster.id}`}
          type="button"
          class="button small"
          data-testid="stop-poster"
          data-text={poster.text}
          title={stops.lack(poster) || t("A stop before the poster {text}", { text: poster.text })}
          disabled={!allowed || stops.lack(poster) !== ""}
          onClick={() => void stops.fromPoster(poster)}
        >
          <PlusIcon /> {poster.text.length > 26 ? `${poster.text.slice(0, 25)}…` : poster.text}
        </button>
      ))}
      {free.length > 0 && (
        <select
          aria-label={t("A stop at a place of the map")}
          data-testid="stop-place"
          value=""
          disabled={!allowed}
          onChange={(event) => {
            const place = free.find(({ id }) => id === event.currentTarget.value);
            event.currentTarget.value = "";
            if (place) void stops.at(place);
          }}
        >
          <option value="">{t("At a place…")}</option>
          {free.map(({ id, name }) => (
            <option key={id} value={id}>
              {name}
            </option>
          ))}
        </select>
      )}
    </div>
  );
}
