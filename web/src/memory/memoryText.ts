/** What is remembered, in words. Pure. */

import { plural, t } from "../i18n";
import type { EpisodeSummary, MemoryEvent, MemoryItem, MemoryState } from "../protocol/types";
import { ago, number, spaced } from "../ui/format";

/** Below this an item hardly belongs to its event. */
const FIRM = 0.3;

/** A thing of an event: "someone", "“heavy”", "at lab". */
export function itemWords({ channel, item }: Pick<MemoryItem, "channel" | "item">): string {
  if (channel === "place") return t("at {place}", { place: item.slice(item.indexOf("/") + 1) });
  if (channel === "desire") return spaced(item.replace(/#.*$/, ""));
  if (item === "someone") return t("someone");
  const [kind, ...rest] = item.split(" ");
  const name = rest.join(" ");
  if (kind === "person") return t("person {number}", { number: name });
  if (kind === "word") return t("“{word}”", { word: name });
  if (kind === "code") return t("code {name}", { name });
  return item;
}

/** What an event is, without what it has in common with the one before. */
export function eventWords(event: MemoryEvent, before?: MemoryEvent): string {
  const firm = (of: MemoryEvent) => of.items.filter((item) => item.weight >= FIRM && item.channel !== "emotion");
  const known = new Set(before ? firm(before).map(itemKey) : []);
  const fresh = firm(event).filter((item) => !known.has(itemKey(item)));
  return (fresh.length > 0 ? fresh : firm(event)).map(itemWords).join(", ");
}

function itemKey({ channel, item }: MemoryItem): string {
  return `${channel} ${item}`;
}

/** "This is like episode 3 (92 %), which has happened 5 times." */
export function recognizedWords(state: MemoryState): string {
  if (state.recognized === null)
    return state.under_way.length > 0 ? t("Nothing that is remembered is like this.") : t("Nothing happens.");
  const times = state.episodes.find((episode) => episode.id === state.recognized)?.times ?? 1;
  const values = { id: state.recognized, match: number(100 * state.match, 0) };
  return plural(
    times,
    "This is like episode {id} ({match} %), which has happened once.",
    "This is like episode {id} ({match} %), which has happened {count} times.",
    values,
  );
}

/** "5 times, last 2 h ago". */
export function timesWords(episode: EpisodeSummary, now: number | null): string {
  const times = plural(episode.times, "once", "{count} times");
  return now === null ? times : t("{times}, last {ago}", { times, ago: ago(now - episode.last) });
}
