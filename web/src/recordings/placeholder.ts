/** The tab that a replay will open in, while it starts. */

import { shown, t } from "../i18n";

const STYLE = `
  body { margin: 0; height: 100vh; display: grid; place-content: center; justify-items: center; gap: 14px;
    background: #0a0d12; color: #e9eef5; font: 15px/1.5 system-ui, sans-serif; text-align: center; padding: 0 16px }
  p { margin: 0 } small { color: #a3b1c2; font-size: 13px }
  i { width: 26px; height: 26px; border: 3px solid #5b6a7d; border-top-color: #6aa5ff; border-radius: 50%;
    animation: turn .9s linear infinite }
  @keyframes turn { to { transform: rotate(1turn) } }
`;

export interface Placeholder {
  go(url: string): void;
  close(): void;
}

/** Null where the browser opens no tab: then the page shows a link. */
export function starting(name: string): Placeholder | null {
  const tab = window.open("", "_blank");
  if (!tab) return null;
  const page = tab.document;
  page.title = t("Starting the replay of {name}…", { name });
  page.documentElement.lang = shown.peek().language;
  const style = page.createElement("style");
  style.textContent = STYLE;
  page.head.append(style);
  const text = page.createElement("p");
  text.textContent = page.title;
  const more = page.createElement("small");
  more.textContent = t("It does not affect the robot. This takes some seconds.");
  page.body.append(page.createElement("i"), text, more);
  return {
    go: (url) => {
      if (tab.closed) return;
      tab.opener = null;
      tab.location.replace(url);
    },
    close: () => tab.close(),
  };
}
