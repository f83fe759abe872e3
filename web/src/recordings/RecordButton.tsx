/** The Recorder in the bar: one press records, one press stops or saves; what is being written is seen at any time. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { clockSpan, sentence, size } from "../ui/format";
import { RecordIcon, RingIcon, SquareIcon, WarnIcon } from "../ui/icons";
import { recordedFor } from "./recordingText";

export function RecordButton() {
  const { store, recordings } = useApp();
  const recorder = store.of("recorder").value;
  if (!recorder?.available || store.replay.value) return null;
  const pending = recordings.pending.value;
  const live = store.live.value;
  const length = clockSpan(recordedFor(recorder, store.now.value));
  const common = { "data-testid": "record", "data-state": recorder.state, type: "button" as const };
  if (pending === "start" || pending === "stop")
    return (
      <button {...common} class="record pending" disabled>
        <span class="spinner" aria-hidden="true" /> {pending === "start" ? t("Starting…") : t("Stopping…")}
      </button>
    );
  if (recorder.state === "recording")
    return (
      <button
        {...common}
        class="record recording"
        disabled={!live}
        aria-label={t("Stop recording. {length} recorded, {size}", { length, size: size(recorder.bytes) })}
        title={t("Stop recording")}
        onClick={(event) => {
          leave(event);
          void recordings.stop();
        }}
      >
        <SquareIcon />
        <span data-testid="record-time">{length}</span>
        <small data-testid="record-size">{size(recorder.bytes)}</small>
        {recorder.dropped > 0 && <WarnIcon />}
      </button>
    );
  if (recorder.state === "ring")
    return (
      <button
        {...common}
        class="record ring"
        disabled={!live || pending === "save"}
        aria-label={t("Save the last {length}", { length })}
        title={t("Save the ring as a recording")}
        onClick={(event) => {
          leave(event);
          void recordings.save();
        }}
      >
        <RingIcon />
        <span class="record-word">{pending === "save" ? t("Saving…") : t("Save last")}</span>
        <span data-testid="record-time">{length}</span>
      </button>
    );
  if (recorder.state === "stopped" || (recorder.desired && recorder.reason))
    return (
      <button
        {...common}
        class="record stopped"
        title={sentence(recorder.reason)}
        onClick={(event) => {
          leave(event);
          store.tab.value = "recordings";
        }}
      >
        <WarnIcon /> <span class="record-word">{t("Not recording")}</span>
        <span class="only-narrow">{t("Stopped")}</span>
      </button>
    );
  return (
    <button
      {...common}
      class="record"
      disabled={!live}
      aria-label={t("Record")}
      title={t("Record what the robot perceives and does")}
      onClick={(event) => {
        leave(event);
        void recordings.record({});
      }}
    >
      <RecordIcon /> <span>{t("Record")}</span>
    </button>
  );
}

/** Pressed with the mouse it does not keep the focus: Space stops driving, and must not record as well. */
function leave(event: MouseEvent & { currentTarget: HTMLElement }): void {
  if (event.detail > 0) event.currentTarget.blur();
}
