/**
 * What the robot feels: a name, a figure and a thin line for each emotion, over the lanes. Under the pointer, or once
 * pressed, each says whose neglect and success it comes from, and whether face and voice show it. Loaded once something
 * is felt.
 */

import { useSignal } from "@preact/signals";
import { named, t } from "../i18n";
import type { EmotionLevel, ShownEmotion } from "../protocol/types";
import { number, spaced } from "../ui/format";

const COLORS = { joy: "var(--mark)", anger: "var(--bad)", sadness: "var(--rate)", fear: "var(--violet)" } as const;

/** The emotion, how strong it is, and whose neglect and success it comes from. */
export function feelingWords({ emotion, intensity, sources }: EmotionLevel): string {
  const from = sources.map((source) => {
    const words = `${spaced(source.class)} ${number(source.share, 2)}`;
    return source.neglected ? `${words} (${t("neglected")})` : words;
  });
  return [`${named(emotion)} ${number(intensity, 2)}`, ...from].join("\n");
}

/** Where an emotion shows; empty where another does, or none. */
export function shownWords(emotion: string, shown: ShownEmotion | null): string {
  if (shown?.emotion !== emotion) return "";
  return shown.desire ? t("Face and voice show it.") : t("The voice shows it.");
}

interface Props {
  levels: readonly EmotionLevel[];
  shown: ShownEmotion | null;
}

export function Feelings({ levels, shown }: Props) {
  const open = useSignal("");
  return (
    <div class="feelings" role="group" aria-label={t("Emotions")} data-testid="emotions">
      {levels.map((level) => {
        const { emotion, intensity } = level;
        const [, ...from] = feelingWords(level).split("\n");
        if (from.length === 0) from.push(t("No desire feeds it now."));
        const shows = shownWords(emotion, shown);
        const why = (shows ? [...from, shows] : from).join("\n");
        return (
          <button
            key={emotion}
            type="button"
            class={`feeling ${open.value === emotion ? "open" : ""} ${shows ? "shown" : ""}`}
            aria-description={why}
            aria-expanded={open.value === emotion}
            data-emotion={emotion}
            data-intensity={intensity}
            onClick={() => (open.value = open.peek() === emotion ? "" : emotion)}
            onBlur={() => (open.value = "")}
          >
            <span class="feeling-name">{named(emotion)}</span>
            <span class="feeling-figure">{number(intensity, 2)}</span>
            <span class="feeling-line">
              <span style={{ width: `${100 * intensity}%`, background: COLORS[emotion] }} />
            </span>
            <span class="feeling-why" aria-hidden="true">
              {why}
            </span>
          </button>
        );
      })}
    </div>
  );
}
