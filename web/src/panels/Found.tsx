/** The QR codes found so far: what they say, where they are from here, how sure and how fresh. */

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
    <section class="card" aria-label="Found QR codes" data-testid="found">
      <h2>
        QR codes found <span class="count">{landmarks.length}</span>
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
          {`at (${number(x, 2)}, ${number(y, 2)}, ${number(z, 2)}) m ± ${number(sigma_m * 100, 0)} cm`}
        </p>
        <p class="muted small">
          {sightings === 1 ? "seen once" : `seen ${sightings} times`}
          {now !== null && `, last ${ago(now - last_seen)}`}
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
        title={stops.lack(landmark) || "Make a stop of the tour before it"}
        disabled={stops.lack(landmark) !== ""}
        onClick={() => void stops.fromPoster(landmark)}
      >
        Make a stop
      </button>
    );
  const place = placeOf(places.all.value, landmark);
  if (place)
    return store.body.value.goes ? (
      <button
        type="button"
        class="button small"
        data-testid="landmark-go"
        title={`Go to ${place.name}`}
        onClick={() => void map.goToPlace(place.id)}
      >
        Go
      </button>
    ) : null;
  const lack = posterLack(landmark);
  return (
    <button
      type="button"
      class="button small quiet"
      data-testid="landmark-place"
      title={lack || "Make a place in front of it"}
      disabled={lack !== "" || places.busy.value}
      onClick={() => void places.addBefore(landmark)}
    >
      Place
    </button>
  );
}

/** "2.4 m away, ahead on the left, " from where the robot stands. */
function bearing(landmark: Landmark, robot: Pose | null): string {
  if (!robot) return "";
  const [dx, dy] = [landmark.x - robot.x, landmark.y - robot.y];
  const turn = Math.atan2(dy, dx) - robot.theta;
  const angle = Math.atan2(Math.sin(turn), Math.cos(turn));
  const side = angle > 0 ? "left" : "right";
  const size = Math.abs(angle);
  const where = size < 0.26 ? "ahead" : size < 1.05 ? `ahead on the ${side}` : size < 2.1 ? `on the ${side}` : "behind";
  return `${number(Math.hypot(dx, dy), 1)} m away, ${where}, `;
}
