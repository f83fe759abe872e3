/** The name of the tour that is edited, what became of the edits, and whose counts where two people changed the same. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { LeftIcon, UndoIcon, WarnIcon } from "../ui/icons";
import { textOf } from "./tourEdits";

export function TourHead() {
  const { stops, tourRun, tours } = useApp();
  const tour = tours.draft.value!;
  const kept = tours.kept.value;
  const state = tours.conflict.value
    ? t("Not kept")
    : tours.busy.value
      ? t("Saving…")
      : tours.unsaved.value
        ? t("Not kept")
        : t("Kept");
  return (
    <>
      <h2 class="card-head tour-head">
        <button
          type="button"
          class="icon-button"
          data-testid="tour-close"
          aria-label={t("All tours")}
          title={t("All tours")}
          onClick={() => {
            stops.open.value = null;
            tourRun.wanted.value = tour.id; // what was edited is what is led next
            tours.close();
            void tours.refresh();
          }}
        >
          <LeftIcon />
        </button>
        <span class="tour-name">{textOf(tour.title, tour.languages)}</span>
        <span
          class={`tour-state small ${tours.conflict.value || tours.unsaved.value ? "bad" : ""}`}
          role="status"
          data-testid="tour-state"
        >
          {state}
        </span>
        <button
          type="button"
          class="icon-button"
          data-testid="tour-undo"
          aria-label={t("Undo")}
          title={t("Undo the last change of this tour, anyone's")}
          disabled={!kept?.can_undo || tours.busy.value}
          onClick={() => void tours.undo("undo")}
        >
          <UndoIcon />
        </button>
        <button
          type="button"
          class="icon-button mirrored"
          data-testid="tour-redo"
          aria-label={t("Redo")}
          title={t("Redo")}
          disabled={!kept?.can_redo || tours.busy.value}
          onClick={() => void tours.undo("redo")}
        >
          <UndoIcon />
        </button>
      </h2>
      {tours.refusal.value && (
        <p class="inline-note error" role="alert" data-testid="tour-refusal">
          <WarnIcon />
          <span>{tours.refusal.value}</span>
          {tours.unsaved.value && (
            <button type="button" class="button small" onClick={() => void tours.save()}>
              {t("Again")}
            </button>
          )}
        </p>
      )}
    </>
  );
}

/** Another editor changed the same. */
export function ConflictNote() {
  const { tours } = useApp();
  const conflict = tours.conflict.value;
  if (!conflict) return null;
  return (
    <div class="inline-note error stacked" role="alert" data-testid="tour-conflict">
      <b>{t("Another editor has changed the same: {paths}.", { paths: conflict.paths.join(", ") })}</b>
      <span>{t("What only one of you has changed is kept in any case.")}</span>
      <span class="form-actions">
        <button type="button" class="button small" data-testid="tour-mine" onClick={() => void tours.decide("mine")}>
          {t("Keep mine")}
        </button>
        <button
          type="button"
          class="button small"
          data-testid="tour-theirs"
          onClick={() => void tours.decide("theirs")}
        >
          {t("Take theirs")}
        </button>
      </span>
    </div>
  );
}
