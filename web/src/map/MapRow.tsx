/** One kept map: its picture, what is known of it, and what can be done with it. */

import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { fromRobot, t } from "../i18n";
import type { KeptMap } from "../protocol/types";
import { useApp } from "../state/context";
import { dayTime, number } from "../ui/format";
import { PencilIcon, TrashIcon } from "../ui/icons";
import { Confirm } from "./Confirm";
import { nameProblem } from "./library";

export function MapRow({ kept }: { kept: KeptMap }) {
  const { maps, session } = useApp();
  const open = useSignal<"load" | "rename" | "delete" | null>(null);
  const { name } = kept;
  const inUse = maps.inUse.value === name;
  const busy = maps.doing.value !== "";
  const toggle = (what: "load" | "rename" | "delete") => (open.value = open.value === what ? null : what);
  return (
    <li class="kept-map" data-testid="kept-map" data-name={name} data-in-use={inUse}>
      {kept.problem ? (
        <span class="map-thumb" aria-hidden="true" />
      ) : (
        <img
          class="map-thumb"
          src={session.rest.mapPicture(name, kept.saved)}
          alt={t("Map {name} from above", { name })}
          loading="lazy"
        />
      )}
      <div class="map-facts">
        <p class="recording-head">
          <b>{name}</b>
          {inUse && <span class="tag in-use">{t("in use")}</span>}
        </p>
        <p class="muted small">{kept.problem === null ? factsOf(kept) : fromRobot(kept.problem)}</p>
        <p class="muted small">{t("saved {time}", { time: dayTime(kept.saved) })}</p>
        <div class="recording-actions">
          <button
            type="button"
            class="button small"
            data-testid="map-load"
            aria-expanded={open.value === "load"}
            disabled={busy || kept.problem !== null || !maps.available.value}
            onClick={() => toggle("load")}
          >
            {t("Load…")}
          </button>
          <button
            type="button"
            class="icon-button"
            data-testid="map-rename"
            aria-label={t("Rename {name}…", { name })}
            title={t("Rename…")}
            disabled={busy}
            onClick={() => toggle("rename")}
          >
            <PencilIcon />
          </button>
          <button
            type="button"
            class="icon-button"
            data-testid="map-delete"
            aria-label={t("Delete {name}…", { name })}
            title={inUse ? t("The map in use cannot be deleted") : t("Delete…")}
            disabled={busy || inUse}
            onClick={() => toggle("delete")}
          >
            <TrashIcon />
          </button>
        </div>
      </div>
      {open.value === "load" && <LoadForm kept={kept} onDone={() => (open.value = null)} />}
      {open.value === "rename" && <RenameForm name={name} onDone={() => (open.value = null)} />}
      {open.value === "delete" && (
        <Confirm
          words={t("Delete {name} for good?", { name })}
          yes={t("Delete")}
          onYes={() => void maps.remove(name)}
          onNo={() => (open.value = null)}
        />
      )}
    </li>
  );
}

/** What is asked before a map is taken into use. */
export function LoadForm({ kept, onDone }: { kept: KeptMap; onDone: () => void }) {
  const { maps, store } = useApp();
  const id = useId();
  const extend = useSignal(false);
  const localization = store.of("localization").value;
  /** It is loaded again, and the robot knows where it is on it. */
  const known =
    maps.inUse.value === kept.name && (localization?.state === "tracking" || localization?.state === "mapping");
  const chosen = useSignal<"here" | "anywhere" | "start" | null>(null);
  const where = chosen.value === "here" && !known ? "anywhere" : (chosen.value ?? (known ? "here" : "anywhere"));
  const unsaved = localization !== null && maps.inUse.value === "";
  return (
    <form
      class="map-form"
      ref={inSight}
      onSubmit={(event) => {
        event.preventDefault();
        const { x, y, theta } = where === "here" ? localization! : { x: 0, y: 0, theta: 0 };
        void maps
          .load(kept.name, { ...(where === "anywhere" ? {} : { pose: { x, y, theta } }), extend: extend.value })
          .then((done) => done && onDone());
      }}
    >
      <fieldset>
        <legend>{t("The map")}</legend>
        <Choice group={`${id}-map`} id="map-localize" checked={!extend.value} onChoose={() => (extend.value = false)}>
          {t("is not changed: only localize on it")}
        </Choice>
        <Choice
          group={`${id}-map`}
          id="map-extend"
          checked={extend.value}
          disabled={!kept.extendable}
          onChoose={() => (extend.value = true)}
        >
          {kept.extendable ? t("is extended: continue mapping") : t("cannot be extended: it has no pose graph")}
        </Choice>
      </fieldset>
      <fieldset>
        <legend>{t("The robot")}</legend>
        {known && (
          <Choice
            group={`${id}-robot`}
            id="map-here"
            checked={where === "here"}
            onChoose={() => (chosen.value = "here")}
          >
            {t("is where it found itself on it")}
          </Choice>
        )}
        <Choice
          group={`${id}-robot`}
          id="map-anywhere"
          checked={where === "anywhere"}
          onChoose={() => (chosen.value = "anywhere")}
        >
          {t("is somewhere on it: search for its pose")}
        </Choice>
        <Choice
          group={`${id}-robot`}
          id="map-at-start"
          checked={where === "start"}
          onChoose={() => (chosen.value = "start")}
        >
          {t("is at the start of the map")}
        </Choice>
      </fieldset>
      {unsaved && <p class="inline-note warn">{t("The map in use is not saved. Loading another one discards it.")}</p>}
      <div class="form-actions">
        <button
          type="submit"
          class="button small accent"
          data-testid="map-load-confirm"
          disabled={maps.doing.value !== ""}
        >
          {t("Load {name}", { name: kept.name })}
        </button>
        <button type="button" class="button small" onClick={onDone}>
          {t("Not now")}
        </button>
      </div>
    </form>
  );
}

/** A form that opens below the edge would look as if nothing had happened. */
function inSight(form: HTMLFormElement | null): void {
  form?.scrollIntoView({ block: "nearest" });
}

function Choice(props: {
  group: string;
  id: string;
  checked: boolean;
  disabled?: boolean;
  onChoose: () => void;
  children: string;
}) {
  return (
    <label class={`check ${props.disabled ? "muted" : ""}`}>
      <input
        type="radio"
        name={props.group}
        data-testid={props.id}
        checked={props.checked}
        disabled={props.disabled ?? false}
        onChange={props.onChoose}
      />
      <span>{props.children}</span>
    </label>
  );
}

function RenameForm({ name, onDone }: { name: string; onDone: () => void }) {
  const { maps } = useApp();
  const to = useSignal(name);
  const others = maps.list.value?.maps.map((one) => one.name) ?? [];
  const typed = to.value.trim();
  const wrong =
    typed === name ? "" : nameProblem(typed) || (others.includes(typed) ? t("Another map has this name.") : "");
  return (
    <form
      class="map-form"
      onSubmit={(event) => {
        event.preventDefault();
        if (wrong || typed === name) return;
        void maps.rename(name, typed).then((done) => done && onDone());
      }}
    >
      <div class={`field ${wrong ? "wrong" : ""}`}>
        <input
          aria-label={t("New name of {name}", { name })}
          data-testid="map-new-name"
          value={to.value}
          autocomplete="off"
          ref={(field) => {
            if (field && document.activeElement !== field && to.peek() === name) field.focus();
          }}
          onInput={(event) => (to.value = event.currentTarget.value)}
        />
        {wrong && <span class="field-error">{wrong}</span>}
      </div>
      <div class="form-actions">
        <button
          type="submit"
          class="button small accent"
          data-testid="map-rename-confirm"
          disabled={wrong !== "" || typed === name}
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

/** "12 × 9 m, 85 m² known, 2 zones". */
function factsOf({ size_m, known_m2, zones }: KeptMap): string {
  const size = t("{width} × {depth} m, {known} m² known", {
    width: number(size_m[0], 0),
    depth: number(size_m[1], 0),
    known: number(known_m2, 0),
  });
  return zones === 0 ? size : `${size}, ${zones} ${zones === 1 ? "zone" : "zones"}`;
}
