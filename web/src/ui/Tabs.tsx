/** The side column: one subject at a time, by the tab pattern of WAI-ARIA. */

import type { ComponentChildren } from "preact";
import { t } from "../i18n";
import { useApp } from "../state/context";

export interface TabItem {
  id: string;
  title: string;
  badge?: string | number;
  alarm?: boolean;
  content: () => ComponentChildren;
}

export function Tabs({ items }: { items: TabItem[] }) {
  const { store } = useApp();
  const chosen = items.find((item) => item.id === store.tab.value) ?? items[0]!;
  const move = (event: KeyboardEvent) => {
    const by = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (by === 0) return;
    event.preventDefault();
    const next = items[(items.indexOf(chosen) + by + items.length) % items.length]!;
    store.tab.value = next.id;
    document.getElementById(`tab-${next.id}`)?.focus();
  };
  return (
    <aside class="tabs panel" aria-label={t("Panels")}>
      <div class="tab-list" role="tablist" data-own-arrows onKeyDown={move}>
        {items.map((item) => (
          <button
            key={item.id}
            id={`tab-${item.id}`}
            type="button"
            role="tab"
            class={item.alarm ? "alarm" : ""}
            aria-selected={item === chosen}
            aria-controls="tab-panel"
            tabIndex={item === chosen ? 0 : -1}
            data-testid={`tab-${item.id}`}
            onFocus={(event) => event.currentTarget.scrollIntoView({ inline: "nearest", block: "nearest" })}
            onClick={(event) => {
              store.tab.value = item.id;
              // Chosen with the mouse, the tab does not keep the arrow keys from driving.
              if (event.detail > 0) event.currentTarget.blur();
            }}
          >
            {item.title}
            {item.badge !== undefined && item.badge !== 0 && <span class="badge">{item.badge}</span>}
          </button>
        ))}
      </div>
      <div class="tab-panel" id="tab-panel" role="tabpanel" aria-labelledby={`tab-${chosen.id}`} tabIndex={-1}>
        {chosen.content()}
      </div>
    </aside>
  );
}
