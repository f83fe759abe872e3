/** How the camera's pictures come to this page: as video or as JPEGs, how large, and why not as video. */

import { useApp } from "../state/context";
import { panel } from "./panel";

export const picturesPanel = panel({
  type: "load",
  tab: "Load",
  Card: Pictures,
  offered: ({ store }) => store.hello.value?.channels.camera !== false,
});

function Pictures() {
  const { store, camera } = useApp();
  const coding = camera.coding.value;
  const problem = store.hello.value?.vp9 === false ? "the robot's computer has no encoder (PyAV)" : camera.noVp9.value;
  return (
    <section class="card" aria-label="Camera pictures" data-testid="pictures" data-coding={coding}>
      <h2>Camera pictures</h2>
      <p class="muted small">
        {coding === "" ? "None has come yet." : `${coding}, ${camera.shownSize.value}.`}{" "}
        {problem ? `As JPEG alone: ${problem}.` : "As VP9 where the link is short, else as JPEG."}
      </p>
    </section>
  );
}
