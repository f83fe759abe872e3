/** How one drives: the style of keys and stick, and what a gamepad's sticks and buttons do. */

import { type Text, t } from "../i18n";
import { useApp } from "../state/context";
import { SlidersIcon } from "../ui/icons";
import { later } from "../ui/later";
import { usePopup } from "../ui/usePopup";
import { STYLES, type Style } from "./driveStyle";

const PadEditor = later(async () => (await import("./PadEditor")).PadEditor);

const STYLE_WORDS: Record<Style, readonly [Text, Text]> = {
  hold: ["Hold", "The robot moves while a key or the stick is held"],
  step: ["Step", "Each press moves it for a moment, then it stops"],
  click: ["Click", "One press sets it going, any next stops it"],
};

export function DriveSettings() {
  const { drive } = useApp();
  const { open, button, box } = usePopup();
  return (
    <>
      <button
        type="button"
        ref={button}
        class="icon-button drive-settings"
        aria-label={t("How you drive: {style}", { style: t(STYLE_WORDS[drive.style.value][0]) })}
        aria-expanded={open.value}
        aria-haspopup="dialog"
        title={t("How you drive: hold, step or click; gamepads")}
        data-testid="drive-settings"
        onClick={() => (open.value = !open.value)}
      >
        <SlidersIcon />
      </button>
      {open.value && (
        <div
          class="drive-box"
          ref={box}
          role="dialog"
          aria-label={t("How you drive")}
          data-testid="drive-box"
          data-own-arrows
        >
          <div class="segmented" role="radiogroup" aria-label={t("Keys and stick")}>
            {STYLES.map((style) => (
              <button
                key={style}
                type="button"
                role="radio"
                aria-checked={drive.style.value === style}
                data-testid={`style-${style}`}
                title={t(STYLE_WORDS[style][1])}
                onClick={() => drive.choose(style)}
              >
                {t(STYLE_WORDS[style][0])}
              </button>
            ))}
          </div>
          <p class="small">
            {t(STYLE_WORDS[drive.style.value][1])}.{" "}
            {t("In each, a lost link, a hidden page and another window stop it.")}
          </p>
          <PadEditor />
        </div>
      )}
    </>
  );
}
