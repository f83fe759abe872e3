/** The picture or video of a step: seen, handed in from this computer, or chosen from what the robot has. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { listed, t } from "../i18n";
import { Confirm } from "../map/Confirm";
import type { TourMedia } from "../protocol/types";
import { useApp } from "../state/context";
import { TrashIcon, WarnIcon } from "../ui/icons";
import { TAKEN } from "./mediaControl";

const VIDEO = /\.(mp4|webm)$/i;

interface Props {
  /** As the tour names it. */
  file: string;
  onDone: (file: string) => void;
}

export function MediaFields({ file, onDone }: Props) {
  const { session, tours } = useApp();
  const { media } = tours;
  const over = useSignal(false);
  const choosing = useSignal(false);
  useEffect(() => media.clear(), [media]);
  // With each version of the tour that is kept, others of its media are in use.
  const version = tours.kept.value?.etag;
  useEffect(() => void media.refresh(), [media, version]);
  const found = media.list.value?.media ?? [];
  const there = found.some((each) => each.file === file);
  const sent = media.upload.value;
  const take = async (files: FileList | null | undefined) => {
    const added = files?.[0] && (await media.add(files[0]));
    if (!added) return;
    choosing.value = false;
    onDone(added);
  };
  return (
    <section
      class={`tour-media ${over.value ? "over" : ""}`}
      aria-label={t("Picture or video")}
      data-testid="media-drop"
      onDragOver={(event) => {
        event.preventDefault();
        over.value = true;
      }}
      onDragLeave={() => (over.value = false)}
      onDrop={(event) => {
        event.preventDefault();
        over.value = false;
        if (tours.allowed.value) void take(event.dataTransfer?.files);
      }}
    >
      {there && <Thumbnail key={file} file={file} testid="media-shown" controls />}
      {sent ? (
        <div class="tour-media-sent" data-testid="media-sent">
          <span class="small">{sent.name}</span>
          <progress aria-label={t("How much of the file is there")} value={sent.share} />
          <button type="button" class="button small" data-testid="media-cancel" onClick={() => media.cancel()}>
            {t("Cancel")}
          </button>
        </div>
      ) : (
        <div class="tour-adds">
          <label class={`button small ${tours.allowed.value ? "" : "disabled"}`}>
            {t("Upload…")}
            <input
              type="file"
              class="visually-hidden"
              data-testid="media-upload"
              accept={TAKEN.join(",")}
              disabled={!tours.allowed.value}
              onChange={(event) => {
                const input = event.currentTarget;
                void take(input.files).finally(() => (input.value = ""));
              }}
            />
          </label>
          <button
            type="button"
            class={`button small ${choosing.value ? "on" : ""}`}
            data-testid="media-choose"
            aria-expanded={choosing.value}
            onClick={() => (choosing.value = !choosing.value)}
          >
            {t("On the robot ({count})", { count: found.length })}
          </button>
          <span class="field-hint">{t("or drop a file here")}</span>
        </div>
      )}
      {media.refusal.value && (
        <p class="inline-note error" role="alert" data-testid="media-refusal">
          <WarnIcon />
          <span>{media.refusal.value}</span>
        </p>
      )}
      {choosing.value && (
        <ul class="tour-media-list" data-testid="media-list">
          {found.map((each) => (
            <Row
              key={each.file}
              media={each}
              chosen={each.file === file}
              onChoose={() => {
                choosing.value = false;
                onDone(each.file);
              }}
            />
          ))}
          {found.length === 0 && <li class="empty">{t("No picture yet.")}</li>}
        </ul>
      )}
      {there && (
        <a class="small" href={session.tourRest.tourMediaFile(file)} target="_blank" rel="noreferrer">
          {t("Open it whole")}
        </a>
      )}
    </section>
  );
}

function Row({ media, chosen, onChoose }: { media: TourMedia; chosen: boolean; onChoose: () => void }) {
  const { tours } = useApp();
  const asking = useSignal(false);
  const { file, size, tours: users } = media;
  const used = users.length > 0 ? t("Shown by {tours}", { tours: listed(users) }) : "";
  return (
    <li data-testid="media-row" data-file={file}>
      <button type="button" class="tour-media-row" aria-pressed={chosen} data-testid="media-take" onClick={onChoose}>
        <Thumbnail file={file} />
        <span>
          {file}
          <span class="muted small">
            {` ${size < 1024 ** 2 ? `${Math.ceil(size / 1024)} kB` : `${(size / 1024 ** 2).toFixed(1)} MB`}`}
          </span>
        </span>
      </button>
      <button
        type="button"
        class="icon-button"
        aria-label={t("Delete {file}", { file })}
        title={media.shipped ? t("It came with the program") : used || t("Delete")}
        data-testid="media-delete"
        disabled={media.shipped || used !== "" || !tours.allowed.value}
        onClick={() => (asking.value = true)}
      >
        <TrashIcon />
      </button>
      {asking.value && (
        <Confirm
          words={t("Delete it for good?")}
          yes={t("Delete")}
          onYes={() => void tours.media.remove(media)}
          onNo={() => (asking.value = false)}
        />
      )}
    </li>
  );
}

function Thumbnail({ file, testid, controls = false }: { file: string; testid?: string; controls?: boolean }) {
  const { session } = useApp();
  const bad = useSignal(false);
  const address = session.tourRest.tourMediaFile(file);
  if (bad.value) return <span class="muted small">{t("This browser cannot show {file}.", { file })}</span>;
  const shared = { "data-testid": testid, src: address, onError: () => (bad.value = true) };
  return VIDEO.test(file) ? (
    <video {...shared} muted playsInline preload="metadata" controls={controls} />
  ) : (
    <img {...shared} alt="" loading="lazy" />
  );
}
