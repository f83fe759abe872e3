/** How the camera's pictures come to this page: as video or as JPEGs, how large, and why not as video. */

import { t } from "../i18n";
import { useApp } from "../state/context";

export function Pictures() {
  const { store, camera } = useApp();
  const coding = camera.coding.value;
  const problem =
    store.hello.value?.vp9 === false ? t("the robot's computer has no encoder (PyAV)") : camera.noVp9.value;
  return (
    <section class="card" aria-label={t("Camera pictures")} data-testid="pictures" data-coding={coding}>
      <h2>{t("Camera pictures")}</h2>
      <p class="muted small">
        {coding === "" ? t("None has come yet.") : `${coding}, ${camera.shownSize.value}.`}{" "}
        {problem ? t("As JPEG alone: {problem}.", { problem }) : t("As VP9 where the link is short, else as JPEG.")}
      </p>
    </section>
  );
}
