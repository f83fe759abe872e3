/** Over the view while a tour is configured by driving: what was met, and the end of it. */

import { useSignal } from "@preact/signals";
import { plural, rich, t } from "../i18n";
import { nameProblem } from "../map/library";
import { useApp } from "../state/context";
import { CloseIcon, QrIcon, WarnIcon } from "../ui/icons";
import { newId, posterTitle } from "./tourEdits";

export function TourDriveBanner() {
  const { maps, store, tourDrive } = useApp();
  /** Null: nothing was typed, the map is called as the tour. */
  const typed = useSignal<string | null>(null);
  const tour = tourDrive.tour.value;
  if (!tour || store.replay.value) return null;
  const unnamed = (maps.inUse.value ?? "") === "";
  const others = maps.list.value?.maps.map((map) => map.name) ?? [];
  const name = typed.value ?? newId(tour.title, others, "map");
  const wrong = unnamed ? nameProblem(name.trim()) : "";
  const ready = tour.met.length > 0 && store.live.value && !tourDrive.busy.value;
  const finish = async () => {
    await tourDrive.finish(name);
    if (tourDrive.tour.peek()) return;
    typed.value = null;
    store.tab.value = "tour";
  };
  return (
    <section
      class="tour-drive"
      aria-label={t("Configuring a tour by driving")}
      data-testid="tour-driving"
      data-met={tour.met.length}
    >
      <p>{rich("{title}: drive past the posters in the order of the tour.", { title: <b>{tour.title}</b> })}</p>
      {tour.met.length > 0 && (
        <ol class="tour-met">
          {tour.met.map(({ text, landmark }) => (
            <li key={landmark} data-testid="tour-met" data-text={text}>
              <QrIcon />
              <span title={text}>{posterTitle(text)}</span>
              <button
                type="button"
                class="icon-button"
                aria-label={t("Leave out {text}", { text: posterTitle(text) })}
                onClick={() => tourDrive.leaveOut(landmark)}
              >
                <CloseIcon />
              </button>
            </li>
          ))}
        </ol>
      )}
      {tourDrive.problem.value && (
        <p class="inline-note error" role="alert">
          <WarnIcon />
          <span>{tourDrive.problem.value}</span>
        </p>
      )}
      <form
        class="tour-drive-end"
        onSubmit={(event) => {
          event.preventDefault();
          if (ready && !wrong) void finish();
        }}
      >
        {unnamed && (
          <label class="tour-drive-name">
            <span>{t("Keep the map as")}</span>
            <input
              data-testid="tour-drive-map"
              value={name}
              autocomplete="off"
              onInput={(event) => (typed.value = event.currentTarget.value)}
            />
          </label>
        )}
        <button
          type="submit"
          class="button small accent"
          data-testid="tour-drive-finish"
          disabled={!ready || wrong !== ""}
        >
          {tourDrive.busy.value
            ? t("Keeping…")
            : plural(tour.met.length, "Finish with {count} stop", "Finish with {count} stops")}
        </button>
        <button type="button" class="button small" data-testid="tour-drive-discard" onClick={() => tourDrive.discard()}>
          {t("Discard")}
        </button>
      </form>
      {wrong && <p class="field-error">{wrong}</p>}
    </section>
  );
}
