/** Frames around the faces and QR codes in the camera's picture: who, how far, what it says. */

import { useRef } from "preact/hooks";
import { personWords } from "../around/perceptMarks";
import { t } from "../i18n";
import type { Perceived, SeenCode, SeenFace } from "../protocol/types";
import { useApp } from "../state/context";
import { codesOn, cutOff, facesOn, nearSide, type Trails, trailed } from "./faces";

export function FaceFrames({ message: perceived }: { message: Perceived | null }) {
  const { store, camera } = useApp();
  const status = store.of("status").value;
  // The camera turns with the base, and with any joint that may carry it.
  const joints = Math.max(0, ...(status?.groups ?? []).map(({ speed_radps }) => speed_radps));
  const turning = Math.abs(status?.odometry?.angular_radps ?? 0) + joints;
  const seen = useRef<{ of: Perceived | null; trails: Trails }>({ of: null, trails: new Map() });
  if (seen.current.of !== perceived) seen.current = { of: perceived, trails: trailed(seen.current.trails, perceived) };
  const faces = facesOn(seen.current.trails, camera.stamp.value, turning);
  const codes = codesOn(perceived, camera.stamp.value, turning);
  const [width, height] = faces[0]?.image ?? codes[0]?.image ?? [4, 3];
  return (
    <div class="face-frames" style={{ "--shape": width / height }} aria-hidden="true">
      {codes.map((code) => (
        <CodeFrame key={code.text} code={code} />
      ))}
      {faces.map((face) => (
        <FaceFrame key={face.track} face={face} />
      ))}
    </div>
  );
}

function FaceFrame({ face }: { face: SeenFace }) {
  const [name, range] = personWords(face).split(", ");
  return (
    <div
      class={`face-frame ${nearTop(face.box[1], face)} ${nearSide(face.box[0], face.box[2], face.image[0])}`}
      data-testid="face-frame"
      data-track={face.track}
      style={placed(face.box, face)}
    >
      <span>
        {name}
        {range && <i>{`, ${range}`}</i>}
      </span>
    </div>
  );
}

function CodeFrame({ code }: { code: SeenCode }) {
  const { stops, store, tours } = useApp();
  const landmark = store.of("landmarks").value?.landmarks.find(({ text }) => text === code.text);
  const stoppable = landmark !== undefined && tours.draft.value !== null && stops.lack(landmark) === "";
  const us = code.corners.map(([u]) => u);
  const vs = code.corners.map(([, v]) => v);
  const [left, top] = [Math.min(...us), Math.min(...vs)];
  const box: Box = [left, top, Math.max(...us) - left, Math.max(...vs) - top];
  return (
    <div
      class={`face-frame code ${nearTop(top, code)} ${nearSide(box[0], box[2], code.image[0])}`}
      data-testid="code-frame"
      data-text={code.text}
      style={placed(box, code)}
    >
      <span>{code.text.length > 24 ? `${code.text.slice(0, 23)}…` : code.text}</span>
      {stoppable && (
        <button
          type="button"
          class="button small accent"
          data-testid="code-stop"
          tabIndex={-1}
          onClick={() => void stops.fromPoster(landmark)}
        >
          {t("Make a stop")}
        </button>
      )}
    </div>
  );
}

type Box = [number, number, number, number];

/** Its words go below it where there is no room above. */
function nearTop(top: number, seen: SeenFace | SeenCode): string {
  return top < 0.12 * seen.image[1] ? "low" : "";
}

function placed([left, top, width, height]: Box, seen: SeenFace | SeenCode): Record<string, string> {
  const [across, down] = seen.image;
  return {
    "--cut": `${cutOff(left, width, across)}%`,
    left: `${(100 * left) / across}%`,
    top: `${(100 * top) / down}%`,
    width: `${(100 * width) / across}%`,
    height: `${(100 * height) / down}%`,
  };
}
