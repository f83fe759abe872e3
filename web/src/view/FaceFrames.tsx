/** Frames around the faces in the camera's picture, with name and distance. */

import { useApp } from "../state/context";
import { personWords } from "../around/marks";
import { facesOn } from "./faces";

export function FaceFrames() {
  const { store, camera } = useApp();
  const turning = Math.abs(store.status.value?.odometry?.angular_radps ?? 0);
  const faces = facesOn(store.perceived.value, camera.stamp.value, turning);
  const [width, height] = faces[0]?.image ?? [4, 3];
  return (
    <div class="face-frames" style={{ "--shape": width / height }} aria-hidden="true">
      {faces.map((face) => {
        const [left, top, w, h] = face.box;
        const [across, down] = face.image!;
        const [name, range] = personWords(face).split(", ");
        return (
          <div
            key={face.track}
            class={`face-frame ${top < 0.12 * down ? "low" : ""}`}
            data-testid="face-frame"
            data-track={face.track}
            style={{
              left: `${(100 * left) / across}%`,
              top: `${(100 * top) / down}%`,
              width: `${(100 * w) / across}%`,
              height: `${(100 * h) / down}%`,
            }}
          >
            <span>
              {name}
              {range && <i>{`, ${range}`}</i>}
            </span>
          </div>
        );
      })}
    </div>
  );
}
