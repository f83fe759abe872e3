/** The tab of tours: all of them, or the one that is edited. */

import { useSignal } from "@preact/signals";
import { plural, t } from "../i18n";
import type { TourSummary } from "../protocol/types";
import { useApp } from "../state/context";
import { PlusIcon, QrIcon, WarnIcon } from "../ui/icons";
import { TypedField } from "./parts";
import { TourEditor } from "./TourEditor";
import { newTour, textOf } from "./tourEdits";

export function Tours() {
  const { tours } = useApp();
  return tours.draft.value ? <TourEditor /> : <TourList />;
}

function TourList() {
  const { tours } = useApp();
  const list = tours.list.value;
  const problem = tours.refusal.value || tours.unread.value;
  return (
    <section class="card" aria-label={t("Tours")} data-testid="tours">
      <h2 class="card-head">
        {t("Tours")} <span class="count">{list?.tours.length ?? ""}</span>
        <label
          class={`button small quiet ${tours.allowed.value ? "" : "disabled"}`}
          title={t("Import a tour's file (YAML), or its archive with pictures (ZIP)")}
        >
          {t("Import")}
          <input
            type="file"
            class="visually-hidden"
            data-testid="tour-import"
            accept=".yaml,.yml,.json,.zip"
            disabled={!tours.allowed.value}
            onChange={(event) => {
              const input = event.currentTarget;
              const file = input.files?.[0];
              if (file) void tours.importFile(file);
              input.value = "";
            }}
          />
        </label>
      </h2>
      {problem && (
        <p class="inline-note error" role="alert" data-testid="tours-problem">
          <WarnIcon />
          <span>{problem}</span>
        </p>
      )}
      {list === null ? (
        <p class="empty">{tours.unread.value ? t("The list could not be read.") : t("Reading the list…")}</p>
      ) : list.tours.length === 0 ? (
        <p class="empty">{t("No tour yet.")}</p>
      ) : (
        <ul class="tours">
          {list.tours.map((tour) => (
            <Row key={tour.id} tour={tour} />
          ))}
        </ul>
      )}
      <NewTour />
    </section>
  );
}

function Row({ tour }: { tour: TourSummary }) {
  const { grid, map, tours } = useApp();
  const open = async (id: string) => {
    // All of its way is in sight.
    if (await tours.open(id)) map.fit(grid.map.picture.peek());
  };
  const { id, stops, errors, problem } = tour;
  return (
    <li class="tour-row" data-testid="tour" data-id={id} data-errors={errors}>
      <button
        type="button"
        class="tour-open"
        data-testid="tour-open"
        disabled={problem !== null || tours.busy.value}
        onClick={() => void open(id)}
      >
        <b>{textOf(tour.title, tour.languages) || id}</b>
        <span class="muted small">
          {problem ??
            t(tour.shipped ? "{stops} on the map {map}, an example" : "{stops} on the map {map}", {
              stops: plural(stops, "{count} stop", "{count} stops"),
              map: tour.map,
            })}
        </span>
        {errors > 0 && (
          <span class="tour-lack small">
            {plural(errors, "{count} thing is missing", "{count} things are missing")}
          </span>
        )}
      </button>
    </li>
  );
}

/** By hand, stop after stop; or by driving past the posters. */
function NewTour() {
  const { tours, tourDrive, maps, store } = useApp();
  const title = useSignal("");
  const language = useSignal("en");
  const known = store.of("localization").value !== null;
  // Without a title, the browser asks for it at the press: a button that does nothing would not say why.
  const ready = tours.allowed.value && !tours.busy.value;
  const drives = store.body.value.drives && store.body.value.places;
  const map = maps.inUse.value ?? "";
  return (
    <form
      class="tour-new"
      onSubmit={(event) => {
        event.preventDefault();
        const taken = (tours.list.peek()?.tours ?? []).map(({ id }) => id);
        if (ready && map) void tours.create(newTour(title.peek(), language.peek(), map, taken));
      }}
    >
      <h3>{t("A new tour")}</h3>
      <div class="tour-new-fields">
        <div class="field">
          <label for="tour-new-title">{t("Title")}</label>
          <input
            id="tour-new-title"
            data-testid="tour-new-title"
            value={title.value}
            maxLength={100}
            placeholder={t("such as: The robotics lab")}
            required
            pattern=".*\S.*"
            autocomplete="off"
            onInput={(event) => (title.value = event.currentTarget.value)}
          />
        </div>
        <TypedField
          label={t("Language")}
          value={language.value}
          testid="tour-new-language"
          maxLength={20}
          onDone={(tag) => (language.value = tag.trim().toLowerCase() || "en")}
        />
      </div>
      <div class="tour-new-ways">
        {drives && (
          <button
            type="button"
            class="button accent"
            data-testid="tour-drive"
            disabled={!ready || tourDrive.tour.value !== null}
            onClick={(event) => {
              if (event.currentTarget.form?.reportValidity())
                void tourDrive.begin(title.peek().trim(), language.peek());
            }}
          >
            <QrIcon /> {t("By driving")}
          </button>
        )}
        <button
          type="submit"
          class="button"
          data-testid="tour-new"
          title={map ? t("On the map {map}", { map }) : t("Save the map first: a tour is on a map that has a name")}
          disabled={!ready || map === ""}
        >
          <PlusIcon /> {t("By hand")}
        </button>
      </div>
      <p class="field-hint">
        {t(
          "By driving: hang posters at the stops, then drive once past them; each that the robot reads becomes a stop.",
        )}{" "}
        {!map && (known ? t("By hand: save the map first.") : t("By hand: there is no map yet."))}
      </p>
    </form>
  );
}
