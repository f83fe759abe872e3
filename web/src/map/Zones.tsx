/** The zones of the map: their list, and the one that is selected, to name, slow down or delete. */

import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { t } from "../i18n";
import type { Zone } from "../protocol/types";
import { useApp } from "../state/context";
import { number } from "../ui/format";
import { KeepOutIcon, SlowIcon, TrashIcon, UndoIcon } from "../ui/icons";
import { asSpeed, changed, nameProblem, removed } from "./zoneList";

export function Zones() {
  const { map, store } = useApp();
  const replay = store.replay.value;
  const zones = map.zones.value;
  return (
    <section class="card" aria-label={t("Zones")} data-testid="zones">
      <h2 class="card-head">
        {t("Zones")} <span class="count">{zones.length}</span>
        {!replay && (
          <button
            type="button"
            class="button small quiet"
            data-testid="zones-undo"
            disabled={!map.canUndo || !map.allowed.value}
            onClick={() => void map.undo()}
          >
            <UndoIcon /> {t("Undo")}
          </button>
        )}
      </h2>
      {zones.length === 0 ? (
        <p class="empty">
          {replay
            ? t("None at this time of the recording.")
            : t("None. Draw one with Keep out (the robot stays out) or Slow (it drives slowly).")}
        </p>
      ) : (
        <ul class="zones">
          {zones.map((zone) => (
            <Row key={zone.name} zone={zone} />
          ))}
        </ul>
      )}
    </section>
  );
}

function Row({ zone }: { zone: Zone }) {
  const { map } = useApp();
  const open = map.selected.value === zone.name;
  return (
    <li
      class={`zone ${zone.kind} ${open ? "open" : ""}`}
      data-testid="zone"
      data-name={zone.name}
      data-kind={zone.kind}
      data-speed={zone.speed}
    >
      <button
        type="button"
        class="zone-head"
        aria-expanded={open}
        onClick={() => (map.selected.value = open ? null : zone.name)}
      >
        {zone.kind === "slow" ? <SlowIcon /> : <KeepOutIcon />}
        <b>{zone.name}</b>
        <span class="muted">
          {zone.kind === "slow" ? t("slow, {share} %", { share: Math.round(zone.speed * 100) }) : t("keep out")}
        </span>
      </button>
      {open && map.allowed.value && <ZoneEditor zone={zone} />}
    </li>
  );
}

export function ZoneEditor({ zone, onDone }: { zone: Zone; onDone?: () => void }) {
  const { map, store } = useApp();
  const id = useId();
  const name = useSignal(zone.name);
  const speed = useSignal(zone.speed);
  const zones = map.zones.value;
  const wrong = nameProblem(zones, name.value, zone.name);
  const fastest = store.hello.value?.robot.limits.linear_mps;
  const edit = (change: Partial<Zone>) => void map.editZones(changed(zones, zone.name, change));
  const rename = () => {
    const to = name.value.trim();
    if (wrong || to === zone.name) return;
    map.selected.value = to;
    edit({ name: to });
    map.selected.value = to;
  };
  return (
    <div class="zone-editor">
      <div class={`field ${wrong ? "wrong" : ""}`}>
        <label for={`${id}-name`}>{t("Name")}</label>
        <input
          id={`${id}-name`}
          data-testid="zone-name"
          value={name.value}
          maxLength={60}
          onInput={(event) => (name.value = event.currentTarget.value)}
          onKeyDown={(event) => event.key === "Enter" && event.currentTarget.blur()}
          onBlur={rename}
        />
        {wrong && <span class="field-error">{wrong}</span>}
      </div>
      <div class="field">
        <label for={`${id}-kind`}>{t("The robot")}</label>
        <select
          id={`${id}-kind`}
          data-testid="zone-kind"
          value={zone.kind}
          onChange={(event) =>
            edit({ kind: event.currentTarget.value as Zone["kind"], speed: zone.kind === "slow" ? 1 : 0.4 })
          }
        >
          <option value="keep_out">{t("keeps out")}</option>
          <option value="slow">{t("goes slowly")}</option>
        </select>
      </div>
      {zone.kind === "slow" && (
        <div class="zone-speed">
          <label for={`${id}-speed`}>{t("At most")}</label>
          <input
            id={`${id}-speed`}
            data-testid="zone-speed"
            type="range"
            min={0.05}
            max={1}
            step={0.05}
            value={speed.value}
            onInput={(event) => (speed.value = asSpeed(Number(event.currentTarget.value)))}
            onChange={(event) => edit({ speed: asSpeed(Number(event.currentTarget.value)) })}
          />
          <output for={`${id}-speed`}>
            {Math.round(speed.value * 100)} %{fastest !== undefined && `, ${number(speed.value * fastest, 2)} m/s`}
          </output>
        </div>
      )}
      <div class="form-actions">
        <button
          type="button"
          class="button small"
          data-testid="zone-delete"
          onClick={() => void map.editZones(removed(zones, zone.name))}
        >
          <TrashIcon /> {t("Delete")}
        </button>
        {onDone && (
          <button type="button" class="button small" onClick={onDone}>
            {t("Done")}
          </button>
        )}
      </div>
    </div>
  );
}
