/** The viewpoints of the 3D view: a button and a key each, at its edge. */

import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { typesText } from "../drive/driveController";
import type { FollowControl } from "../drive/followControl";
import { LEAST_LIMIT_DEG, MOST_LIMIT_DEG } from "../drive/viewFollow";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { sceneAge } from "./pictureAge";
import type { SceneFrame } from "./sceneFrame";
import { VIEWPOINTS, type Viewpoint, viewpointOf } from "./viewpoints";

/** Turned by the user alone: what follows it comes to rest. */
const FOLLOWED: Viewpoint = "free";

export function ViewpointStrip({ scene, follow }: { scene: SceneFrame; follow: FollowControl }) {
  const { store } = useApp();
  const camera = scene.camera.value;
  const { turnsHead, maps } = store.body.value;
  const pictures = store.hello.value?.channels.camera !== false;
  const able: Partial<Record<Viewpoint, boolean>> = { head: turnsHead, first_person: pictures, map: maps };
  const offered = VIEWPOINTS.filter(({ name }) => able[name] !== false);
  const look = (name: Viewpoint) => {
    // A view that turns with the robot would run ahead of a robot that turns after it.
    if (name !== FOLLOWED) follow.choose(1);
    scene.look(name);
  };
  const follows = follow.mode.value === 2;
  const limit = follow.limit.value;
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      const name = viewpointOf(event);
      if (event.repeat || typesText(event.target) || !offered.some((each) => each.name === name)) return;
      event.preventDefault();
      look(name!);
    };
    window.addEventListener("keydown", press);
    return () => window.removeEventListener("keydown", press);
  }, [offered.length, scene]);
  return (
    <div
      class="viewpoints"
      role="toolbar"
      aria-label={t("Viewpoints of the 3D view")}
      data-testid="viewpoints"
      data-arrived={camera?.arrived ? camera.viewpoint : ""}
    >
      {offered.map(({ name, code, words }) => (
        <button
          key={name}
          type="button"
          class="viewpoint"
          data-testid={`viewpoint-${name}`}
          aria-label={t(words)}
          aria-pressed={(camera?.viewpoint ?? "behind") === name}
          aria-keyshortcuts={code.slice(-1)}
          title={`${t(words)} (${code.slice(-1)})`}
          onClick={() => look(name)}
        >
          <svg class="icon" viewBox="0 0 24 24" aria-hidden="true">
            {ICONS[name]}
          </svg>
          <kbd>{code.slice(-1)}</kbd>
        </button>
      ))}
      {turnsHead && !store.replay.value && (
        <button
          type="button"
          class="viewpoint follow"
          data-testid="view-follow"
          aria-label={t("Head follows the view")}
          aria-pressed={follows}
          title={
            follows
              ? t("The head follows the view while you drag it or drive; {limit}° aside, the robot turns after it", {
                  limit,
                })
              : t("The head looks ahead. Press: it follows the view while you drag it")
          }
          onClick={() => {
            if (follows) follow.choose(1);
            else {
              scene.look(FOLLOWED);
              follow.choose(2);
            }
          }}
        >
          <svg class="icon" viewBox="0 0 24 24" aria-hidden="true">
            <circle cx="12" cy="15" r="4.5" />
            <path d="M4 9a10 10 0 0 1 16 0M20 4v5h-5" />
          </svg>
        </button>
      )}
      <SceneAge stamp={scene.stamp.value} />
      {follows && (
        <label class="soft-limit" title={t("So far aside the head follows alone; beyond it, the robot turns")}>
          <span>{limit}°</span>
          <input
            type="range"
            aria-label={t("Degrees aside from which the robot turns after the view")}
            data-testid="soft-limit"
            min={LEAST_LIMIT_DEG}
            max={MOST_LIMIT_DEG}
            step={5}
            value={limit}
            onInput={(event) => follow.setLimit(Number(event.currentTarget.value))}
          />
        </label>
      )}
    </div>
  );
}

/** How old it is what the 3D view shows: refreshed with the robot's clock, also while nothing new is drawn. */
function SceneAge({ stamp }: { stamp: number | null }) {
  const { store } = useApp();
  const now = store.now.value;
  const age = now !== null && stamp !== null ? sceneAge(now - stamp, store.clock.rate, store.replay.value) : null;
  return (
    age && (
      <span class={`scene-age ${age.late ? "late" : ""}`} data-testid="scene-age" title={age.title}>
        {age.text}
      </span>
    )
  );
}

/** The robot, as seen from the viewpoint, or the way it is seen from. */
const ICONS: Record<Viewpoint, ComponentChildren> = {
  behind: (
    <>
      <path d="M12 4v5M9.5 6.5L12 4l2.5 2.5" />
      <rect x="8" y="12" width="8" height="8" rx="2" />
    </>
  ),
  aligned: (
    <>
      <circle cx="12" cy="14" r="3" />
      <path d="M5 21c1-3 4-4 7-4s6 1 7 4M12 3v6M9.5 5.5L12 3l2.5 2.5" />
    </>
  ),
  free: (
    <>
      <ellipse cx="12" cy="12" rx="9" ry="4" />
      <path d="M12 3c3 4 3 14 0 18M18 15l1.5 2" />
    </>
  ),
  head: (
    <>
      <circle cx="9" cy="15" r="4" />
      <path d="M12 12l7-7M19 10V5h-5" />
    </>
  ),
  first_person: (
    <>
      <path d="M3 12s3.5-6 9-6 9 6 9 6-3.5 6-9 6-9-6-9-6z" />
      <circle cx="12" cy="12" r="2.5" />
    </>
  ),
  top: (
    <>
      <path d="M12 3v8M9 8l3 3 3-3" />
      <path d="M4 17l8-4 8 4-8 4z" />
    </>
  ),
  map: (
    <>
      <path d="M3 6l6-2 6 2 6-2v14l-6 2-6-2-6 2z" />
      <path d="M9 4v14M15 6v14" />
    </>
  ),
};
