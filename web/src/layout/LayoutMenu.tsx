/** The page's layout: presets, what is shown, where, its colours, and the link to it. */

import { type Text, t } from "../i18n";
import { LanguageChoice } from "../i18n/LanguageChoice";
import { useApp } from "../state/context";
import { LayoutIcon } from "../ui/icons";
import { usePopup } from "../ui/usePopup";
import { PRESETS, type Preset } from "./layout";
import { THEMES, theme } from "./theme";

const NAMES: Record<Preset, Text> = {
  drive: "Drive|preset",
  tour: "Tour",
  attention: "Attention",
  debug: "Debug",
};
const WORDS: Record<Preset, Text> = {
  drive: "The view, with the map beside it",
  tour: "The map, with the stops beside it",
  attention: "The view, the lanes and why",
  debug: "Load, events and large lanes",
};
const THEME_NAMES = { system: "As the system", light: "Light", dark: "Dark" } as const;

export function LayoutMenu() {
  const { layout, store } = useApp();
  const { open, button, box, close } = usePopup("[aria-checked=true]");
  const { sideShown, lanesShown, edge, lanesAt } = layout.layout.value;
  const presets = PRESETS.filter((preset) => preset !== "tour" || store.body.value.maps);
  return (
    <div class="layout-menu">
      <button
        type="button"
        ref={button}
        class="button small"
        data-testid="layout"
        aria-haspopup="dialog"
        aria-expanded={open.value}
        aria-label={t("Layout: {preset}", { preset: t(NAMES[layout.preset.value]) })}
        title={t("What the page shows, and where")}
        onClick={() => (open.value = !open.value)}
      >
        <LayoutIcon /> <span class="layout-name">{t(NAMES[layout.preset.value])}</span>
      </button>
      {open.value && (
        <div
          class="layout-box"
          ref={box}
          role="dialog"
          aria-label={t("Layout")}
          data-testid="layout-box"
          data-own-arrows
        >
          <div role="radiogroup" aria-label={t("Preset")} class="layout-presets">
            {presets.map((preset) => (
              <button
                key={preset}
                type="button"
                role="radio"
                aria-checked={preset === layout.preset.value}
                data-testid={`layout-${preset}`}
                onClick={() => {
                  layout.choose(preset);
                  close();
                }}
              >
                <b>{t(NAMES[preset])}</b>
                <span>{t(WORDS[preset])}</span>
              </button>
            ))}
          </div>
          <fieldset>
            <legend>{t("Shown")}</legend>
            <Check name={t("Panels")} on={sideShown} id="side" put={(on) => layout.change({ sideShown: on })} />
            <Check name={t("Lanes")} on={lanesShown} id="lanes" put={(on) => layout.change({ lanesShown: on })} />
            <Check
              name={t("Panels on the left")}
              on={edge === "left"}
              id="left"
              put={(on) => layout.change({ edge: on ? "left" : "right" })}
            />
            <Check
              name={t("Lanes on top")}
              on={lanesAt === "top"}
              id="top"
              put={(on) => layout.change({ lanesAt: on ? "top" : "bottom" })}
            />
          </fieldset>
          <label class="layout-theme">
            {t("Colours")}
            <select
              value={theme.value}
              data-testid="theme"
              onChange={(event) => (theme.value = event.currentTarget.value as typeof theme.value)}
            >
              {THEMES.map((each) => (
                <option key={each} value={each}>
                  {t(THEME_NAMES[each])}
                </option>
              ))}
            </select>
          </label>
          <LanguageChoice />
          <div class="layout-actions">
            <button type="button" class="button small" data-testid="layout-link" onClick={() => void copy()}>
              {t("Copy link")}
            </button>
            <button
              type="button"
              class="button small"
              data-testid="layout-reset"
              disabled={!layout.changed.value}
              onClick={() => layout.reset()}
            >
              {t("Reset")}
            </button>
          </div>
        </div>
      )}
    </div>
  );

  async function copy(): Promise<void> {
    const link = layout.link(location.href);
    try {
      await navigator.clipboard.writeText(link);
      store.notify("info", t("The link to this layout is copied."));
    } catch {
      // Without a secure context there is no clipboard: the address bar has it.
      history.replaceState(null, "", link);
      store.notify("info", t("The browser's address is the link to this layout now."));
    }
  }
}

function Check({ name, id, on, put }: { name: string; id: string; on: boolean; put: (on: boolean) => void }) {
  return (
    <label>
      <input
        type="checkbox"
        checked={on}
        data-testid={`layout-shows-${id}`}
        onChange={(event) => put(event.currentTarget.checked)}
      />
      {name}
    </label>
  );
}
