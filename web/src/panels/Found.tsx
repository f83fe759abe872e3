/** The QR codes found so far: what they say, where they are from here, how sure and how fresh. */

import { plural, type Text, t } from "../i18n";
import { robotOn } from "../map/mapControl";
import type { Pose } from "../map/mapProjection";
import { placeOf, posterLack } from "../map/placeControl";
import type { Landmark } from "../protocol/types";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { stopOf } from "../tours/tourEdits";
import { ago, number } from "../ui/format";
import { QrIcon } from "../ui/icons";
import { noneFound } from "./foundText";
import { panel } from "./panel";

export const foundPanel = panel({
  type: "landmarks",
  tab: "Found",
  Card: Found,
  offered: () => true,
  badge: (message) => message?.landmarks.length ?? 0,
});

function Found({ message }: { message: Message<"landmarks"> | null }) {
  const { store } = useApp();
  const landmarks = message?.landmarks ?? [];
  return (
    <section class="card" aria-label={t("Found QR codes")} data-testid="found">
      <h2>
        {t("QR codes found")} <span class="count">{landmarks.length}</span>
      </h2>
      {landmarks.length === 0 ? (
        <p class="empty">{noneFound(store.body.value, store.replay.value)}</p>
      ) : (
        <ul class="landmarks">
          {landmarks.map((landmark) => (
            <Row key={`${landmark.text}@${landmark.id || landmark.first_seen}`} landmark={landmark} />
          ))}
        </ul>
      )}
    </section>
  );
}

function Row({ landmark }: { landmark: Landmark }) {
  const { store } = useApp();
  const now = store.seconds.value;
  const { text, x, y, z, sigma_m, sightings, last_seen } = landmark;
  const odometry = store.of("status").value?.odometry ?? null;
  const robot = landmark.frame === "map" ? robotOn(store.of("localization").value, odometry) : odometry;
  return (
    <li
      class="landmark"
      data-testid="landmark"
      data-text={text}
      data-x={x}
      data-y={y}
      data-z={z}
      data-sightings={sightings}
    >
      <QrIcon />
      <div>
        <p class="landmark-text">{text}</p>
        <p class="muted small">
          {bearing(landmark, robot)}
          {t("at ({x}, {y}, {z}) m ± {sigma} cm", {
            x: number(x, 2),
            y: number(y, 2),
            z: number(z, 2),
            sigma: number(sigma_m * 100, 0),
          })}
        </p>
        <p class="muted small">
          {plural(sightings, "seen once", "seen {count} times")}
          {now !== null && t(", last {ago}", { ago: ago(now - last_seen) })}
        </p>
      </div>
      <PlaceButton landmark={landmark} />
    </li>
  );
}

/** Makes a stop of the tour that is edited, or a place in front of it; or goes to the one that is there. */
function PlaceButton({ landmark }: { landmark: Landmark }) {
  const { map, places, stops, store, tours } = useApp();
  if (!places.kept.value || !map.allowed.value) return null;
  if (tours.draft.value && !stopOf(tours.draft.value, landmark))
    return (
      <button
        type="button"
        class="button small accent"
        data-testid="landmark-stop"
        title={stops.lack(landmark) || t("Make a stop of the tour before it")}
        disabled={stops.lack(landmark) !== ""}
        onClick={() => void stops.fromPoster(landmark)}
      >
        {t("Make a stop")}
      </button>
    );
  const place = placeOf(places.all.value, landmark);
  if (place)
    return store.body.value.goes ? (
      <button
        type="button"
        class="button small"
        data-testid="landmark-go"
        title={t("Go to {name}", { name: place.name })}
        onClick={() => void map.goToPlace(place.id)}
      >
        {t("Go")}
      </button>
    ) : null;
  const lack = posterLack(landmark);
  return (
    <button
      type="button"
      class="button small quiet"
      data-testid="landmark-place"
      title={lack || t("Make a place in front of it")}
      disabled={lack !== "" || places.busy.value}
      onClick={() => void places.addBefore(landmark)}
    >
      {t("Place")}
    </button>
  );
}

/** "2.4 m away, ahead on the left, " from where the robot stands. */
function bearing(landmark: Landmark, robot: Pose | null): string {
  if (!robot) return "";
  const [dx, dy] = [landmark.x - robot.x, landmark.y - robot.y];
  const turn = Math.atan2(dy, dx) - robot.theta;
  const angle = Math.atan2(Math.sin(turn), Math.cos(turn));
  const metres = number(Math.hypot(dx, dy), 1);
  return `${t("{metres} m away, {where}", { metres, where: t(sideOf(angle)) })}, `;
}

/** `angle`: rad, from straight ahead, over 0 on the left. */
function sideOf(angle: number): Text {
  const size = Math.abs(angle);
  if (size < 0.26) return "ahead";
  if (size < 1.05) return angle > 0 ? "ahead on the left" : "ahead on the right";
  if (size < 2.1) return angle > 0 ? "on the left" : "on the right";
  return "behind";
}
