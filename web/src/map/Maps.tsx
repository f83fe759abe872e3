/** The kept maps: the one in use is saved here, others are loaded, renamed and deleted, and a new one begins. */

import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { rich, t } from "../i18n";
import { useApp } from "../state/context";
import { PlusIcon, WarnIcon } from "../ui/icons";
import { Confirm } from "./Confirm";
import { nameProblem } from "./library";
import { MapRow } from "./MapRow";

export function Maps() {
  const { maps, store } = useApp();
  const list = maps.list.value;
  const problem = maps.problem.value || maps.unread.value;
  const doing = maps.doing.value;
  const present = store.of("localization").value !== null;
  return (
    <section class="card" aria-label={t("Maps")} data-testid="maps">
      <h2 class="card-head">
        {t("Maps")} <span class="count">{list?.maps.length ?? ""}</span>
      </h2>
      {doing && (
        <p class="maps-doing" role="status" data-testid="maps-doing">
          <span class="spinner" aria-hidden="true" /> {doing}
        </p>
      )}
      {problem && (
        <p class="inline-note error" role="alert" data-testid="maps-problem">
          <WarnIcon />
          <span>{problem}</span>
        </p>
      )}
      {list && !maps.available.value && (
        <p class="maps-doing" role="status" data-testid="maps-waiting">
          {t("Maps are not available: the module SLAM2D is not running yet. See Load.")}
        </p>
      )}
      {present && maps.available.value && <Present />}
      {list === null ? (
        <p class="empty">{maps.unread.value ? t("The list could not be read.") : t("Reading the list…")}</p>
      ) : list.maps.length === 0 ? (
        <p class="empty" data-testid="maps-empty">
          {t("No maps saved yet. Drive the robot around, then save the map.")}
        </p>
      ) : (
        <ul class="maps">
          {list.maps.map((one) => (
            <MapRow key={one.name} kept={one} />
          ))}
        </ul>
      )}
      {list && (
        <p class="recordings-room muted small">
          <span class="recordings-folder" title={list.folder}>
            {rich("in {folder}", { folder: <bdi>{list.folder}</bdi> })}
          </span>
        </p>
      )}
    </section>
  );
}

/** The map in use: what it is called, and to keep it; or to leave it for an empty one. */
function Present() {
  const { maps } = useApp();
  const id = useId();
  const inUse = maps.inUse.value ?? "";
  const typed = useSignal<string | null>(null);
  const asking = useSignal<"begin" | "replace" | null>(null);
  const name = (typed.value ?? inUse).trim();
  const wrong = typed.value === null || typed.value === "" ? "" : nameProblem(name);
  const busy = maps.doing.value !== "";
  const taken = name !== inUse && (maps.list.value?.maps.some((one) => one.name === name) ?? false);
  const save = async () => {
    if (taken && asking.peek() !== "replace") {
      asking.value = "replace";
      return;
    }
    asking.value = null;
    if (await maps.save(name)) typed.value = null;
  };
  return (
    <div class="map-present">
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (name && !nameProblem(name) && !busy) void save();
        }}
      >
        <div class={`field ${wrong ? "wrong" : ""}`}>
          <label for={id}>{inUse ? t("Save the map in use as") : t("Save this new map as")}</label>
          <input
            id={id}
            data-testid="map-name"
            value={typed.value ?? inUse}
            placeholder="ground-floor"
            autocomplete="off"
            onInput={(event) => {
              typed.value = event.currentTarget.value;
              asking.value = null;
            }}
          />
          {wrong && <span class="field-error">{wrong}</span>}
        </div>
        <button type="submit" class="button" data-testid="map-save" disabled={busy || nameProblem(name) !== ""}>
          {t("Save")}
        </button>
        <button
          type="button"
          class="button"
          data-testid="map-begin"
          title={t("Start an empty map")}
          disabled={busy}
          onClick={() => (asking.value = asking.value === "begin" ? null : "begin")}
        >
          <PlusIcon /> {t("New")}
        </button>
      </form>
      {asking.value === "replace" && (
        <Confirm
          words={t("A map {name} exists. Replace it?", { name })}
          yes={t("Replace")}
          onYes={() => void save()}
          onNo={() => (asking.value = null)}
        />
      )}
      {asking.value === "begin" && (
        <Confirm
          words={t("Start an empty map here? Unsaved changes of this map are lost.")}
          yes={t("Begin")}
          onYes={() => {
            asking.value = null;
            void maps.begin();
          }}
          onNo={() => (asking.value = null)}
        />
      )}
    </div>
  );
}
