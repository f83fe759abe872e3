/** The map with its tools and the words of the way: in its tab, or over all of the view. */

import type { ComponentChildren } from "preact";
import { t } from "../i18n";
import { panel } from "../panels/panel";
import { useApp } from "../state/context";
import {
  CloseIcon,
  ExploreIcon,
  FlagIcon,
  HomeIcon,
  KeepOutIcon,
  PlaceIcon,
  SearchIcon,
  SlowIcon,
  WarnIcon,
} from "../ui/icons";
import { narrow } from "../ui/media";
import { EXPLORE, explorationsOf, goalOf, hintWords, wayWords } from "./mapText";
import type { Tool } from "./mapTools";
import { Stage, ViewButtons } from "./Stage";
import { ZoneEditor } from "./Zones";

export const mapPanel = panel({
  type: "localization",
  tab: "Map",
  Card: MapInTab,
  offered: ({ store }) => store.body.value.maps,
});

function MapInTab() {
  const { store } = useApp();
  return store.mapPlace.value === "tab" ? <MapPanel place="tab" /> : null;
}

export function MapPanel({ place }: { place: "tab" | "view" }) {
  const { store, map, grid } = useApp();
  const roomy = place === "view" && !narrow.value;
  const selected = map.zones.value.find(({ name }) => name === map.selected.value);
  return (
    <figure
      class={`map in-${place}`}
      data-testid="map"
      data-place={place}
      data-state={grid.map.picture.value?.known ? "shown" : "empty"}
      aria-label={t("Map")}
    >
      <div class="map-head">
        {!store.replay.value && <Tools />}
        {roomy && <ViewButtons />}
      </div>
      {place === "tab" ? (
        <>
          <Way />
          <Stage key="tab" place="tab" buttons />
        </>
      ) : (
        <Stage key="view" place="view" buttons={!roomy}>
          <Way />
        </Stage>
      )}
      {place === "view" && narrow.value && selected && !store.replay.value && (
        <div class="map-zone-bar">
          <ZoneEditor key={selected.name} zone={selected} onDone={() => (map.selected.value = null)} />
        </div>
      )}
    </figure>
  );
}

function Tools() {
  const { map, store } = useApp();
  const allowed = map.allowed.value;
  const known = store.of("localization").value !== null;
  const { goes } = store.body.value;
  const explores = store.rows.value.some((row) => row.class === EXPLORE);
  const exploring = explorationsOf(store.of("desires").value?.desires).length > 0;
  return (
    <div class="map-tools" role="toolbar" aria-label={t("Tools on the map")} data-own-arrows>
      {goes && (
        <>
          <ToolButton
            tool="goal"
            label={t("Go to")}
            hint={t("Press on the goal, drag to set the heading (G)")}
            disabled={!allowed}
          >
            <FlagIcon />
          </ToolButton>
          <button
            type="button"
            class="map-tool"
            data-testid="map-return"
            title={t("Return to the start of the map; gamepad: button 3 (Y, △)")}
            disabled={!allowed}
            onClick={() => void map.returnToStart()}
          >
            <HomeIcon />
            <span>{t("To start")}</span>
          </button>
          {explores && (
            <button
              type="button"
              class={`map-tool ${exploring ? "on" : ""}`}
              data-testid="map-explore"
              aria-pressed={exploring}
              title={t("Have the robot drive to where the map ends, until all that it can reach is mapped")}
              disabled={!allowed}
              onClick={() => void map.explore()}
            >
              <ExploreIcon />
              <span>{t("Explore")}</span>
            </button>
          )}
        </>
      )}
      <ToolButton
        tool="pose"
        label={t("Set pose")}
        hint={t("Press on the robot's place, drag to set its heading")}
        disabled={!allowed || !known}
      >
        <PlaceIcon />
      </ToolButton>
      <button
        type="button"
        class="map-tool"
        data-testid="map-search"
        title={t("Search for the robot's pose on the map")}
        disabled={!allowed || !known}
        onClick={() => void map.search()}
      >
        <SearchIcon />
        <span>{t("Search")}</span>
      </button>
      <ToolButton
        tool="keep_out"
        label={t("Keep out")}
        hint={t("Drag a rectangle, or click corner after corner")}
        disabled={!allowed}
      >
        <KeepOutIcon />
      </ToolButton>
      <ToolButton
        tool="slow"
        label={t("Slow|zone")}
        hint={t("Drag a rectangle, or click corner after corner")}
        disabled={!allowed}
      >
        <SlowIcon />
      </ToolButton>
    </div>
  );
}

function ToolButton(props: {
  tool: Tool;
  label: string;
  hint: string;
  disabled: boolean;
  children: ComponentChildren;
}) {
  const { map, store } = useApp();
  const on = map.tools.value.tool === props.tool;
  return (
    <button
      type="button"
      class={`map-tool ${on ? "on" : ""}`}
      data-testid={`map-tool-${props.tool}`}
      aria-pressed={on}
      title={props.hint}
      disabled={props.disabled}
      onClick={() => {
        // Beside everything else a phone's map is too small to point at.
        if (narrow.value && !on) store.showMap("view");
        map.choose(props.tool);
      }}
    >
      {props.children}
      <span>{props.label}</span>
    </button>
  );
}

/** What the robot is about, what was refused, and what the tool in hand does. */
function Way() {
  const { map, store } = useApp();
  const goal = goalOf(store.of("desires").value?.desires);
  const place = store.of("localization").value;
  const places = store.of("places").value?.places ?? [];
  const words = wayWords(store.of("navigation").value, goal, store.rows.value, store.seconds.value, place, places);
  const { tool } = map.tools.value;
  const hint = hintWords(map.tools.value, goal === null && store.stands.value);
  const problem = map.problem.value;
  const canCancel = goal !== null && map.allowed.value;
  return (
    <div class="map-words">
      {words && (
        <p
          class={`map-way ${words.tone}`}
          role="status"
          data-testid="map-way"
          data-state={words.over ? "given_up" : (store.of("navigation").value?.state ?? "")}
          data-goal={goal ? `${goal.x} ${goal.y}` : ""}
        >
          <span>
            <b>{words.text}</b>
            {words.more && <span class="map-more"> {words.more}</span>}
          </span>
          {canCancel && (
            <button type="button" class="button small" data-testid="map-cancel" onClick={() => void map.cancelGoal()}>
              {t("Cancel")}
            </button>
          )}
          {words.over && map.allowed.value && (
            <button
              type="button"
              class="icon-button"
              data-testid="map-dismiss"
              aria-label={t("Dismiss")}
              onClick={() => void map.cancelGoal()}
            >
              <CloseIcon />
            </button>
          )}
        </p>
      )}
      {problem && (
        <p class="map-way bad" role="alert" data-testid="map-problem">
          <WarnIcon />
          <span>{problem}</span>
          <button type="button" class="icon-button" aria-label={t("Dismiss")} onClick={() => (map.problem.value = "")}>
            <CloseIcon />
          </button>
        </p>
      )}
      <Asleep />
      {hint && (
        <p class="map-way hint" data-testid="map-hint">
          <span>{hint}</span>
          {tool !== "look" && (
            <button type="button" class="button small" data-testid="map-tool-done" onClick={() => map.choose("look")}>
              {t("Done")}
            </button>
          )}
        </p>
      )}
    </div>
  );
}

/** There is a map, but no desire for localization on it. */
function Asleep() {
  const { map, store, grid } = useApp();
  const lane = store.rows.value.find((row) => row.class === "SLAM");
  if (lane?.state !== "undesired" || !grid.map.picture.value?.known || store.replay.value) return null;
  return (
    <p class="map-way warn" data-testid="map-asleep">
      <span>{t("SLAM is not running: there is no desire for it.")}</span>
      {map.allowed.value && (
        <button type="button" class="button small" data-testid="map-desire" onClick={() => void map.desireMap()}>
          {t("Start SLAM")}
        </button>
      )}
    </p>
  );
}
