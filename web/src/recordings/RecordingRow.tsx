/** One recording: what it is, and what can be done with it. Deleting asks once, in its place. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import type { Recording } from "../protocol/types";
import { useApp } from "../state/context";
import type { Store } from "../state/store";
import { clockSpan, dayTime, size } from "../ui/format";
import { DownloadIcon, PlayIcon, TrashIcon, WarnIcon } from "../ui/icons";
import { recordedFor } from "./recordingText";

const STATES = {
  complete: null,
  recording: { word: "being recorded", hint: "" },
  unfinished: { word: "cut off", hint: "The program ended while writing it. To repair it: hbba log repair" },
} as const;

export function RecordingRow({ recording, onGone }: { recording: Recording; onGone: () => void }) {
  const { session, store } = useApp();
  const asking = useSignal(false);
  const { name, state } = recording;
  const tag = STATES[state];
  const { seconds, bytes } = figures(recording, store);
  const facts = [
    recording.began === null ? "" : dayTime(recording.began),
    recording.robot !== store.hello.value?.robot.name ? recording.robot : "",
  ].filter(Boolean);
  return (
    <li
      class={`recording-row ${state === "recording" ? "being-recorded" : state}`}
      data-testid="recording"
      data-name={name}
      data-state={state}
      data-bytes={recording.bytes}
      data-duration={recording.duration_s ?? ""}
    >
      <p class="recording-head">
        <b>{name}</b>
        {tag && (
          <span class={`tag ${state === "recording" ? "being-recorded" : state}`} title={tag.hint && t(tag.hint)}>
            {t(tag.word)}
          </span>
        )}
      </p>
      <p class="recording-facts">
        <span>{facts.join(" · ")}</span>
        <span data-testid="recording-length">{seconds === null ? t("length unknown") : clockSpan(seconds)}</span>
        <span data-testid="recording-size">{size(bytes)}</span>
      </p>
      {state === "unfinished" && <p class="muted small">{`${t(STATES.unfinished.hint)} ${name}`}</p>}
      {state !== "recording" &&
        (asking.value ? (
          <Confirm name={name} onGone={onGone} onKeep={() => (asking.value = false)} />
        ) : (
          <div class="recording-actions">
            <ReplayButton name={name} />
            <a
              class="button small"
              href={session.rest.recordingAddress(name)}
              download={`${name}.mcap`}
              data-testid="recording-download"
              aria-label={t("Download {name}", { name })}
            >
              <DownloadIcon /> {t("Download")}
            </a>
            <button
              type="button"
              class="icon-button"
              data-testid="recording-delete"
              aria-label={t("Delete {name}…", { name })}
              title={t("Delete…")}
              onClick={() => (asking.value = true)}
            >
              <TrashIcon />
            </button>
          </div>
        ))}
      <ReplayNote name={name} />
    </li>
  );
}

/** Of one that is being written, the Recorder knows more than the list read some time ago. */
function figures(recording: Recording, store: Store): { seconds: number | null; bytes: number } {
  const recorder = store.of("recorder").value;
  if (recording.state === "recording" && recorder?.name === recording.name)
    return { seconds: recordedFor(recorder, store.now.value), bytes: recorder.bytes };
  return { seconds: recording.duration_s, bytes: recording.bytes };
}

function ReplayButton({ name }: { name: string }) {
  const { recordings } = useApp();
  const busy = recordings.replays.value[name]?.state === "starting";
  return (
    <button
      type="button"
      class="button small"
      data-testid="recording-replay"
      aria-label={t("Replay {name} in a new tab", { name })}
      disabled={busy}
      onClick={() => void recordings.replay(name)}
    >
      {busy ? <span class="spinner" aria-hidden="true" /> : <PlayIcon />} {busy ? t("Starting…") : t("Replay")}
    </button>
  );
}

function ReplayNote({ name }: { name: string }) {
  const { recordings, store } = useApp();
  const replay = recordings.replays.value[name];
  const list = store.recordings.value?.replay;
  const running = list?.name === name ? list : null;
  if (replay?.state === "failed")
    return (
      <p class="inline-note error" role="alert" data-testid="replay-problem">
        <WarnIcon />
        <span>{replay.text}</span>
      </p>
    );
  if (replay?.state === "starting")
    return (
      <p class="replay-note" role="status" data-testid="replay-state" data-state="starting">
        {t("The replay is starting in a new tab. This takes some seconds.")}
      </p>
    );
  if (!running) return null;
  return (
    <p class="replay-note" data-testid="replay-state" data-state="running">
      <span>{t("The replay runs.")}</span>
      <a href={recordings.address(running.url)} target="_blank" rel="noopener" data-testid="replay-link">
        {t("Open it")}
      </a>
      <button type="button" class="link" data-testid="replay-end" onClick={() => void recordings.endReplay(name)}>
        {t("End it")}
      </button>
    </p>
  );
}

function Confirm({ name, onGone, onKeep }: { name: string; onGone: () => void; onKeep: () => void }) {
  const { recordings } = useApp();
  const keep = useRef<HTMLButtonElement>(null);
  const busy = useSignal(false);
  const problem = useSignal("");
  useEffect(() => keep.current?.focus(), []);
  const remove = async () => {
    busy.value = true;
    problem.value = await recordings.remove(name);
    busy.value = false;
    if (!problem.peek()) onGone();
  };
  return (
    <div class="recording-confirm" role="group" aria-label={t("Delete {name}?", { name })}>
      <span>{t("Delete it for good?")}</span>
      <button
        type="button"
        class="button small danger"
        data-testid="recording-delete-confirm"
        disabled={busy.value}
        onClick={() => void remove()}
      >
        {busy.value ? t("Deleting…") : t("Delete")}
      </button>
      <button type="button" class="button small" ref={keep} data-testid="recording-keep" onClick={onKeep}>
        {t("Keep")}
      </button>
      {problem.value && (
        <p class="inline-note error" role="alert">
          {problem.value}
        </p>
      )}
    </div>
  );
}
