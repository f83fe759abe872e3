/** The places of the map: to go to, rename and delete, and to make where the robot is. */

import { useSignal } from "@preact/signals";
import { t } from "../i18n";
import type { Place } from "../protocol/types";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { sentence } from "../ui/format";
import { PencilIcon, PlaceIcon, QrIcon, TrashIcon } from "../ui/icons";
import { Confirm } from "./Confirm";
import { placeNameProblem } from "./placeControl";

export function Places({ message }: { message: Message<"places"> | null }) {
  const { map, places, store } = useApp();
  const all = message?.places ?? [];
  const replay = store.replay.value;
  const known = store.of("localization").value !== null;
  return (
    <section class="card" aria-label={t("Places")} data-testid="places">
      <h2 class="card-head">
        {t("Places")} <span class="count">{all.length}</span>
        {!replay && (
          <button
            type="button"
            class="button small quiet"
            data-testid="place-here"
            title={t("Make a place where the robot is now")}
            disabled={!map.allowed.value || !known || places.busy.value}
            onClick={() => void places.addHere()}
          >
            <PlaceIcon /> {t("Here")}
          </button>
        )}
      </h2>
      {all.length === 0 ? (
        <p class="empty">
          {replay
            ? t("None at this time of the recording.")
            : t("None. Press Here to name where the robot is, or Place at a code in Found to stand before that.")}
        </p>
      ) : (
        <ul class="places">
          {all.map((place) => (
            <Row key={place.id} place={place} />
          ))}
        </ul>
      )}
    </section>
  );
}

function Row({ place }: { place: Place }) {
  const { map, places, store } = useApp();
  const open = useSignal<"rename" | "delete" | null>(null);
  const { id, name, source, problem } = place;
  const allowed = map.allowed.value;
  const toggle = (what: "rename" | "delete") => (open.value = open.value === what ? null : what);
  return (
    <li class="place" data-testid="place" data-id={id} data-name={name} data-source={source} data-problem={problem}>
      <div class="place-head">
        {source === "poster" ? <QrIcon /> : <PlaceIcon />}
        <b title={source === "poster" ? t("{id}: in front of {poster}", { id, poster: place.poster }) : id}>{name}</b>
        {allowed && (
          <span class="place-actions">
            {store.body.value.goes && (
              <button
                type="button"
                class="button small"
                data-testid="place-go"
                aria-label={t("Go to {name}", { name })}
                onClick={() => void map.goToPlace(id)}
              >
                {t("Go")}
              </button>
            )}
            <button
              type="button"
              class="icon-button"
              data-testid="place-rename"
              aria-label={t("Rename {name}…", { name })}
              title={t("Rename…")}
              aria-expanded={open.value === "rename"}
              onClick={() => toggle("rename")}
            >
              <PencilIcon />
            </button>
            <button
              type="button"
              class="icon-button"
              data-testid="place-delete"
              aria-label={t("Delete {name}…", { name })}
              title={t("Delete…")}
              aria-expanded={open.value === "delete"}
              onClick={() => toggle("delete")}
            >
              <TrashIcon />
            </button>
          </span>
        )}
      </div>
      {problem && <p class="place-problem small">{sentence(problem)}</p>}
      {open.value === "rename" && allowed && <RenameForm place={place} onDone={() => (open.value = null)} />}
      {open.value === "delete" && allowed && (
        <Confirm
          words={t("Delete the place {name}?", { name })}
          yes={t("Delete")}
          onYes={() => void places.remove(place)}
          onNo={() => (open.value = null)}
        />
      )}
    </li>
  );
}

function RenameForm({ place, onDone }: { place: Place; onDone: () => void }) {
  const { places } = useApp();
  // The version that its author sees: a change by another page meanwhile is not overwritten.
  const version = useSignal(place);
  const name = useSignal(place.name);
  const wrong = placeNameProblem(places.all.value, name.value, place);
  const typed = name.value.trim();
  return (
    <form
      class="map-form"
      onSubmit={(event) => {
        event.preventDefault();
        if (!wrong && typed !== place.name)
          void places.rename(version.value, typed).then((done) => {
            if (done) onDone();
            else version.value = place;
          });
      }}
    >
      <div class={`field ${wrong ? "wrong" : ""}`}>
        <input
          aria-label={t("New name of {name}", { name: place.name })}
          data-testid="place-name"
          value={name.value}
          maxLength={60}
          autocomplete="off"
          onInput={(event) => (name.value = event.currentTarget.value)}
        />
        {wrong && <span class="field-error">{wrong}</span>}
      </div>
      <div class="form-actions">
        <button
          type="submit"
          class="button small accent"
          data-testid="place-rename-confirm"
          disabled={wrong !== "" || typed === place.name || places.busy.value}
        >
          {t("Rename")}
        </button>
        <button type="button" class="button small" onClick={onDone}>
          {t("Keep")}
        </button>
      </div>
    </form>
  );
}
