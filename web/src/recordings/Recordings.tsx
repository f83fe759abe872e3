/** The recordings: what is being recorded, and those there are. */

import { useEffect, useRef } from "preact/hooks";
import { rich, t } from "../i18n";
import { useApp } from "../state/context";
import { size } from "../ui/format";
import { WarnIcon } from "../ui/icons";
import { RecorderCard } from "./RecorderCard";
import { RecordingRow } from "./RecordingRow";
import { newestFirst } from "./recordingText";

export function Recordings() {
  const { store, recordings } = useApp();
  const list = store.recordings.value;
  const problem = recordings.problem.value;
  const head = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    store.recordingsShown.value = true;
    return () => {
      store.recordingsShown.value = false;
    };
  }, []);
  return (
    <>
      <RecorderCard />
      {problem && (
        <p class="inline-note error" role="alert" data-testid="recordings-problem">
          <WarnIcon />
          <span>{problem}</span>
        </p>
      )}
      <section class="card" aria-label={t("Recordings")} data-testid="recordings">
        <h2 ref={head} tabIndex={-1}>
          {t("Recordings")} <span class="count">{list?.recordings.length ?? ""}</span>
        </h2>
        {list === null ? (
          <p class="empty">{problem ? t("The list could not be read.") : t("Reading the list…")}</p>
        ) : list.recordings.length === 0 ? (
          <p class="empty" data-testid="recordings-empty">
            {t("None yet. Recordings are stored on the robot; replay them here, or download them.")}
          </p>
        ) : (
          <ul class="recordings">
            {newestFirst(list.recordings).map((recording) => (
              <RecordingRow key={recording.name} recording={recording} onGone={() => head.current?.focus()} />
            ))}
          </ul>
        )}
        {list && (
          <p class="recordings-room muted small">
            {list.free_bytes !== null && (
              <span data-testid="recordings-free" data-bytes={list.free_bytes}>
                {t("{size} free", { size: size(list.free_bytes) })}
              </span>
            )}
            <span class="recordings-folder" title={list.folder}>
              {rich("in {folder}", { folder: <bdi>{list.folder}</bdi> })}
            </span>
          </p>
        )}
      </section>
    </>
  );
}
