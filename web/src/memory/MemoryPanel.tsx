/** What the robot remembers: what happens now and is expected, the episodes, delete and export. */

import { useSignal } from "@preact/signals";
import { fromRobot, plural, t } from "../i18n";
import { Confirm } from "../map/Confirm";
import { inWords } from "../protocol/problem";
import type { EpisodeSummary, MemoryState } from "../protocol/types";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { number, sentence, spaced } from "../ui/format";
import { TrashIcon } from "../ui/icons";
import { eventWords, itemWords, recognizedWords, timesWords } from "./memoryText";

export function Memory({ message }: { message: Message<"memory"> | null }) {
  const { session, store } = useApp();
  const refusal = useSignal("");
  const deleting = useSignal(false);
  if (!message) return null;
  const replayed = store.replay.value;
  const remove = async (request: Promise<void>) => {
    try {
      await request;
      refusal.value = "";
    } catch (error) {
      refusal.value = inWords(error);
    }
  };
  return (
    <section class="card memory" aria-label={t("Memory")} data-testid="memory">
      <h2 class="card-head">
        {t("Memory")} <span class="count">{message.episode_count}</span>
        {!replayed && (
          <a
            class="button small quiet"
            data-testid="memory-export"
            href={session.rest.memoryFile()}
            download="memory.json"
          >
            {t("Export (JSON)")}
          </a>
        )}
        {!replayed && message.episode_count > 0 && !deleting.value && (
          <button
            type="button"
            class="button small quiet"
            data-testid="memory-delete-all"
            onClick={() => (deleting.value = true)}
          >
            {t("Delete all…")}
          </button>
        )}
      </h2>
      {deleting.value && (
        <Confirm
          words={t("All episodes are gone then.")}
          yes={t("Delete all")}
          onYes={() => {
            deleting.value = false;
            void remove(session.rest.deleteMemory());
          }}
          onNo={() => (deleting.value = false)}
        />
      )}
      {refusal.value && (
        <p class="problem" role="alert">
          {refusal.value}
        </p>
      )}
      {message.problem && <p class="problem">{sentence(fromRobot(message.problem))}</p>}
      <Now state={message} />
      <Episodes state={message} onDelete={replayed ? null : (id) => void remove(session.rest.deleteEpisode(id))} />
    </section>
  );
}

/** The strip: what has happened in the episode under way, then what is expected. */
function Now({ state }: { state: MemoryState }) {
  const { under_way, anticipated, raised } = state;
  return (
    <>
      <p data-testid="memory-recognized" data-episode={state.recognized ?? ""}>
        {recognizedWords(state)}
      </p>
      {under_way.length > 0 && (
        // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls sideways, and so by keys
        <ol class="memory-strip" aria-label={t("What happens, and what is expected")} tabIndex={0}>
          {under_way.map((event, i) => (
            <li key={event.id} class="memory-event" data-testid="memory-event">
              {eventWords(event, under_way[i - 1])}
            </li>
          ))}
          {anticipated.map(({ event }, i) => (
            <li key={`next ${event.id}`} class="memory-event expected" data-testid="memory-expected">
              <span class="muted">{t("expected")}</span>{" "}
              {eventWords(event, anticipated[i - 1]?.event ?? under_way[under_way.length - 1])}
            </li>
          ))}
        </ol>
      )}
      {raised.length > 0 && (
        <ul class="memory-raised small">
          {raised.map((desire) => (
            <li key={desire.id} data-testid="memory-raised" data-class={desire.class} title={fromRobot(desire.why)}>
              {t("So it desires {name} ({intensity}).", {
                name: spaced(desire.class),
                intensity: number(desire.intensity, 1),
              })}
            </li>
          ))}
        </ul>
      )}
    </>
  );
}

function Episodes({ state, onDelete }: { state: MemoryState; onDelete: ((id: number) => void) | null }) {
  const { episodes, episode_count } = state;
  if (episodes.length === 0) return <p class="empty">{t("Nothing is remembered yet.")}</p>;
  const more = episode_count - episodes.length;
  return (
    <>
      <ol class="memory-episodes">
        {episodes.map((episode) => (
          <Episode
            key={episode.id}
            episode={episode}
            recognized={episode.id === state.recognized}
            onDelete={onDelete && (() => onDelete(episode.id))}
          />
        ))}
      </ol>
      {more > 0 && (
        <p class="muted small">
          {plural(more, "The export has an older one, too.", "The export has {count} older ones, too.")}
        </p>
      )}
    </>
  );
}

function Episode(props: { episode: EpisodeSummary; recognized: boolean; onDelete: (() => void) | null }) {
  const { store } = useApp();
  const { episode, onDelete } = props;
  return (
    <li
      class={`memory-episode ${props.recognized ? "recognized" : ""}`}
      data-testid="memory-episode"
      data-episode={episode.id}
    >
      <div>
        <p>
          <b>{episode.id}</b> {episode.items.map(itemWords).join(", ")}
        </p>
        <p class="muted small">
          {timesWords(episode, store.seconds.value)}, {plural(episode.events, "{count} event", "{count} events")}
          {episode.deeds.length > 0 &&
            t("; helped by {names}", { names: episode.deeds.map((name) => spaced(name)).join(", ") })}
        </p>
      </div>
      {onDelete && (
        <button
          type="button"
          class="button small quiet"
          data-testid="memory-delete"
          aria-label={t("Delete episode {id}", { id: episode.id })}
          onClick={onDelete}
        >
          <TrashIcon />
        </button>
      )}
    </li>
  );
}
