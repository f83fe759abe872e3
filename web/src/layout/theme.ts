/** The page's colours: light or dark, by the system's choice or this browser's own. */

import { computed, effect, signal } from "@preact/signals";

export const THEMES = ["system", "light", "dark"] as const;
export type Theme = (typeof THEMES)[number];

const KEY = "hbba.theme";

export const theme = signal<Theme>("system");
const light = signal(false);
/** What is shown. */
export const shownTheme = computed<"light" | "dark">(() =>
  theme.value === "system" ? (light.value ? "light" : "dark") : theme.value,
);

/** Takes the kept choice and follows the system; `root` carries the theme for the style sheets. */
export function startTheme(root: HTMLElement, storage: Storage): void {
  theme.value = THEMES.find((each) => each === storage.getItem(KEY)) ?? "system";
  const query = window.matchMedia("(prefers-color-scheme: light)");
  light.value = query.matches;
  query.addEventListener("change", () => (light.value = query.matches));
  effect(() => storage.setItem(KEY, theme.value));
  effect(() => {
    root.dataset["theme"] = shownTheme.value;
  });
}
