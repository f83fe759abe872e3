/** Over the view while a tour is configured by driving: what was met, and the end of it. */

import { useSignal } from "@preact/signals";
import { plural, rich, t } from "../i18n";
import { nameProblem } from "../map/library";
import { useApp } from "../state/context";
import { CloseIcon, QrIcon, WarnIcon } from "../ui/icons";
import { posterTitle } from "./tourEdits";

export function TourDriveBanner() {
  const { maps, store, tourDrive } = useApp();
  const name = useSignal("");
  const tour = tourDrive.tour.value;
  if (!tour || store.replay.value) return null;
  const unnamed = (maps.inUse.value ?? "") === "";
  const wrong = unnamed && name.value !== "" ? nameProblem(name.value.trim()) : "";
  const ready =
    tour.met.length > 0 && store.live.value && !tourDrive.busy.value && (!unnamed || name.value.trim() !== "");
  const finish = async () => {
    await tourDrive.finish(name.peek());
    if (!tourDrive.tour.peek()) store.tab.value = "tour";
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
          <input
            aria-label={t("Keep the map as")}
            placeholder={t("Keep the map as…")}
            data-testid="tour-drive-map"
            value={name.value}
            autocomplete="off"
            onInput={(event) => (name.value = event.currentTarget.value)}
          />
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
