/** What can be done with what was clicked in the 3D view, beside it; and that a click there is waited for. */

import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { type Text, t } from "../i18n";
import { placeOf } from "../map/placeControl";
import { useApp } from "../state/context";
import type { Store } from "../state/store";
import { number } from "../ui/format";
import { CloseIcon, FlagIcon, PlusIcon } from "../ui/icons";
import { goalFor } from "./clickToGo";
import type { Picked, ScenePicking } from "./scenePicking";

/** Clicks from here on (share of the height) have their box above them. */
const LOW = 0.5;
const NAMES: Record<Exclude<Picked["kind"], "poster">, Text> = { floor: "Floor", wall: "Wall", seen: "Obstacle" };

export function ScenePicked({ picking }: { picking: ScenePicking }) {
  const picked = picking.picked.value;
  return picked && <Box key={`${picked.u} ${picked.v}`} picked={picked} onClose={() => picking.close()} />;
}

function Box({ picked, onClose }: { picked: Picked; onClose: () => void }) {
  const { map, places, stops, store, tours } = useApp();
  const box = useRef<HTMLElement>(null);
  useClosing(store, onClose, box);
  const { kind, onMap, poster, u, v } = picked;
  const robot = map.robot.value;
  const place = poster && placeOf(places.all.value, poster);
  const edits = tours.draft.value !== null;
  const goes = store.body.value.goes;
  const lack = onMap
    ? poster && edits
      ? stops.lack(poster)
      : ""
    : t("Where this is on the map is not known: start SLAM.");
  const act = (deed: () => Promise<void>) => () => {
    onClose();
    void deed();
  };
  const go = async () => {
    const goal = robot ? goalFor(picked, robot) : { x: picked.x, y: picked.y, heading: null };
    if (place) await map.goToPlace(place.id);
    else if (goal) await map.goTo(goal.x, goal.y, goal.heading);
    else store.notify("info", t("The robot is there already."));
  };
  const stop = async () => {
    if (poster) await stops.fromPoster(poster);
    else await stops.on(picked, robot ? Math.atan2(picked.y - robot.y, picked.x - robot.x) : 0);
  };
  const words = poster ? poster.text : t(NAMES[kind as keyof typeof NAMES]);
  return (
    <>
      <i class="scene-pin" style={{ left: `${100 * u}%`, top: `${100 * v}%` }} aria-hidden="true" />
      <section
        ref={box}
        class={`scene-picked ${v > LOW ? "above" : ""}`}
        style={{ "--u": u, "--v": v }}
        aria-label={t("What was clicked in the 3D view")}
        data-testid="scene-picked"
        data-kind={kind}
        data-text={poster?.text ?? ""}
      >
        <p>
          <b>{words.length > 60 ? `${words.slice(0, 59)}…` : words}</b>
          {onMap && robot && (
            <span class="muted small">
              {" "}
              {t("{metres} m away", { metres: number(Math.hypot(picked.x - robot.x, picked.y - robot.y), 1) })}
            </span>
          )}
          <button type="button" class="icon-button" aria-label={t("Dismiss")} onClick={onClose}>
            <CloseIcon />
          </button>
        </p>
        {lack && <p class="muted small">{lack}</p>}
        <span class="form-actions">
          {edits && (poster || kind === "floor") && (
            <Deed
              testid="scene-stop"
              accent
              enabled={onMap && tours.allowed.value && (!poster || stops.lack(poster) === "")}
              onClick={act(stop)}
            >
              <PlusIcon /> {poster ? t("Make a stop") : t("Make a stop here")}
            </Deed>
          )}
          {goes && (
            <Deed testid="scene-go" enabled={onMap && map.allowed.value} onClick={act(go)}>
              <FlagIcon /> {kind === "floor" ? t("Go here") : t("Go there")}
            </Deed>
          )}
        </span>
      </section>
    </>
  );
}

function Deed(props: {
  testid: string;
  accent?: boolean;
  enabled: boolean;
  onClick: () => void;
  children: ComponentChildren;
}) {
  return (
    <button
      type="button"
      class={`button small ${props.accent ? "accent" : ""}`}
      data-testid={props.testid}
      disabled={!props.enabled}
      onClick={props.onClick}
    >
      {props.children}
    </button>
  );
}

/** A click in the view is the point of a step. */
export function PointHint() {
  const { store, tourPointing } = useApp();
  const waits = tourPointing.target.value !== null && store.mapPlace.value === "tab";
  return waits ? <Hint onClose={() => tourPointing.choose(null)} /> : null;
}

function Hint({ onClose }: { onClose: () => void }) {
  const { store } = useApp();
  useClosing(store, onClose);
  return (
    <p class="scene-hint map-way hint" role="status" data-testid="scene-hint">
      <span>{t("Click: the point of the step")}</span>
      <button type="button" class="button small" onClick={onClose}>
        {t("Cancel")}
      </button>
    </p>
  );
}

/** Closed by Escape, as everything that opens over the page; what has a `box`, by a press elsewhere on the page, too. */
function useClosing(store: Store, onClose: () => void, box?: { current: HTMLElement | null }): void {
  useLayoutEffect(() => {
    const away = (event: Event) => {
      if (box && !box.current?.contains(event.target as Node)) onClose();
    };
    document.addEventListener("pointerdown", away);
    const closed = store.opened(onClose);
    return () => {
      document.removeEventListener("pointerdown", away);
      closed();
    };
  }, []);
}
