/** Says, in place of the controls, that this is a recording. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { dayTime } from "../ui/format";
import { FilmIcon } from "../ui/icons";
import { isDated } from "./transport";

export function Marker() {
  const { store } = useApp();
  const begin = store.playback.value?.begin ?? 0;
  const file = (store.playback.value?.file ?? "").replace(/^.*[\\/]/, "");
  const robot = store.hello.value?.robot.name ?? t("a robot");
  // A log that does not say whose it is goes by its file and format.
  const named = file === "" || !robot.startsWith(file);
  return (
    <p class="recording-marker" data-testid="recording-marker" title={t("A recording cannot be driven or stopped")}>
      <FilmIcon />
      <span>
        <b>{named ? t("Recording of {robot}", { robot }) : robot}</b>
        <small>
          {[isDated(begin) ? dayTime(begin) : "", named ? file : t("a recording")].filter(Boolean).join(" · ")}
        </small>
      </span>
    </p>
  );
}
