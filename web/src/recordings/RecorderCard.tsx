/** What the Recorder does now, and the form that begins a recording. */

import { useSignal } from "@preact/signals";
import { Labelled } from "../desires/FieldInput";
import { t } from "../i18n";
import type { Recorder } from "../protocol/types";
import { useApp } from "../state/context";
import { clockSpan, number, sentence, size } from "../ui/format";
import { RecordIcon, RingIcon, SquareIcon, WarnIcon } from "../ui/icons";
import type { Pending } from "./recordingControl";
import { nameProblem, recordedFor, ringMinutes } from "./recordingText";

export function RecorderCard() {
  const { store, recordings } = useApp();
  const recorder = store.of("recorder").value;
  if (!recorder?.available)
    return (
      <section class="card" aria-label={t("Recorder")}>
        <p class="empty">{store.live.value ? t("No Recorder is running.") : t("Waiting for the robot…")}</p>
      </section>
    );
  const { state } = recorder;
  const form = state === "idle" && (!recorder.desired || recordings.pending.value === "start");
  return (
    <section class="card recorder" aria-label={t("Recorder")} data-testid="recorder" data-state={state}>
      {(state === "recording" || state === "ring") && <Running recorder={recorder} />}
      {state === "stopped" && (
        <p class="inline-note error recorder-stopped" role="alert">
          <WarnIcon />
          <span>
            <b>{t("Recording has stopped.")}</b> {sentence(recorder.reason)}
          </span>
        </p>
      )}
      {state === "idle" && recorder.desired && recorder.reason && (
        <p class="inline-note warn recorder-stopped" data-testid="recorder-reason">
          <WarnIcon />
          <span>
            <b>{t("Not recording, although desired.")}</b> {sentence(recorder.reason)}
          </span>
        </p>
      )}
      {form ? <Form /> : <Actions recorder={recorder} />}
    </section>
  );
}

function Running({ recorder }: { recorder: Recorder }) {
  const { store } = useApp();
  const ring = recorder.state === "ring";
  return (
    <div class={`recorder-now ${recorder.state}`}>
      <p class="recorder-title">
        {ring ? <RingIcon /> : <RecordIcon />}
        <b>
          {ring
            ? t("Keeping the last {keepMinutes} min", { keepMinutes: number(recorder.keep_minutes) })
            : t("Recording")}
        </b>
        {recorder.name && <span class="muted">{recorder.name}</span>}
      </p>
      <dl class="recorder-figures">
        <div>
          <dt>{ring ? t("Kept") : t("Length")}</dt>
          <dd>{clockSpan(recordedFor(recorder, store.now.value))}</dd>
        </div>
        <div>
          <dt>{t("Size")}</dt>
          <dd>{size(recorder.bytes)}</dd>
        </div>
        <div>
          <dt>{t("Messages")}</dt>
          <dd>{number(recorder.messages, 0)}</dd>
        </div>
        <div class={recorder.dropped > 0 ? "some" : ""} title={t("Messages lost because the disk was too slow")}>
          <dt>{t("Lost|messages")}</dt>
          <dd data-testid="recorder-dropped">{number(recorder.dropped, 0)}</dd>
        </div>
      </dl>
    </div>
  );
}

function Actions({ recorder }: { recorder: Recorder }) {
  const { store, recordings } = useApp();
  const name = useSignal("");
  const ring = recorder.state === "ring";
  const pending = recordings.pending.value;
  const wrong = nameProblem(name.value.trim());
  return (
    <div class="recorder-actions">
      {ring && (
        <Labelled name="save-name" title={t("Save as")} hint={t("empty: named by the time")} error={wrong || undefined}>
          {(props) => (
            <input
              {...props}
              data-testid="ring-name"
              autocomplete="off"
              value={name.value}
              onInput={(event) => (name.value = event.currentTarget.value)}
            />
          )}
        </Labelled>
      )}
      <div class="form-actions">
        {ring && (
          <button
            type="button"
            class="button accent"
            data-testid="ring-save"
            disabled={!store.live.value || pending !== null || wrong !== ""}
            onClick={() =>
              void recordings.save(name.value.trim() || undefined).then((kept) => kept && (name.value = ""))
            }
          >
            {pending === "save"
              ? t("Saving…")
              : t("Save the last {length}", { length: clockSpan(recordedFor(recorder, store.now.value)) })}
          </button>
        )}
        <button
          type="button"
          class="button"
          data-testid="recording-stop"
          disabled={!store.live.value || pending !== null}
          onClick={() => void recordings.stop()}
        >
          <SquareIcon /> {stopWord(recorder.state, pending)}
        </button>
      </div>
    </div>
  );
}

function stopWord(state: Recorder["state"], pending: Pending): string {
  if (pending === "stop") return t("Stopping…");
  if (state === "ring") return t("Stop keeping");
  return state === "recording" ? t("Stop") : t("Stop trying");
}

function Form() {
  const { store, recordings } = useApp();
  const name = useSignal("");
  const keep = useSignal("");
  const minutes = ringMinutes(keep.value);
  const wrongName = nameProblem(name.value.trim());
  const wrongKeep = typeof minutes === "string" ? minutes : "";
  const pending = recordings.pending.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    if (wrongName || typeof minutes === "string") return;
    const typed = name.value.trim();
    await recordings.record({
      ...(typed ? { name: typed } : {}),
      ...(minutes === null ? {} : { keep_minutes: minutes }),
    });
  };
  return (
    <form class="recorder-form" noValidate onSubmit={(event) => void submit(event)} data-testid="recorder-form">
      <h2>{t("Record")}</h2>
      <div class="recorder-fields">
        <Labelled
          name="record-name"
          title={t("Name")}
          hint={t("empty: named by the time")}
          error={wrongName || undefined}
        >
          {(props) => (
            <input
              {...props}
              data-testid="recording-name-field"
              autocomplete="off"
              value={name.value}
              onInput={(event) => (name.value = event.currentTarget.value)}
            />
          )}
        </Labelled>
        <Labelled
          name="record-keep"
          title={t("Keep only the last")}
          hint={t("minutes; empty: all of it")}
          error={wrongKeep || undefined}
        >
          {(props) => (
            <input
              {...props}
              data-testid="recording-keep-field"
              inputMode="decimal"
              autocomplete="off"
              value={keep.value}
              onInput={(event) => (keep.value = event.currentTarget.value)}
            />
          )}
        </Labelled>
      </div>
      <button
        type="submit"
        class="button wide record-start"
        data-testid="recording-start"
        disabled={!store.live.value || pending !== null || wrongName !== "" || wrongKeep !== ""}
      >
        {minutes === null ? <RecordIcon /> : <RingIcon />}
        {pending === "start" ? t("Starting…") : minutes === null ? t("Record") : t("Keep the last minutes")}
      </button>
    </form>
  );
}
