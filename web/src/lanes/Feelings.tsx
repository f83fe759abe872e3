/** What the robot feels: four thin lines over the lanes, as long as each emotion is strong. Loaded once something is felt. */

import { named, t } from "../i18n";
import type { EmotionLevel } from "../protocol/types";
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

export function Feelings({ levels }: { levels: readonly EmotionLevel[] }) {
  return (
    <div role="group" aria-label={t("Emotions")} data-testid="emotions" style="flex:none;padding:2px 0">
      {levels.map((level) => (
        <div
          key={level.emotion}
          role="meter"
          aria-valuemin={0}
          aria-valuemax={1}
          aria-valuenow={level.intensity}
          aria-label={feelingWords(level)}
          title={feelingWords(level)}
          data-emotion={level.emotion}
          style="padding:1px 0"
        >
          <div
            style={{
              height: "2px",
              width: `${100 * level.intensity}%`,
              minWidth: "2px",
              background: COLORS[level.emotion],
            }}
          />
        </div>
      ))}
    </div>
  );
}
