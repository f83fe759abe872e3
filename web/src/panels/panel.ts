/** What a panel of the side column is, and how panels become tabs. Pure. */

import { computed, type ReadonlySignal } from "@preact/signals";
import type { ComponentType } from "preact";
import { type Text, t } from "../i18n";
import type { App } from "../state/context";
import type { Message, MessageType } from "../state/latest";

/** One card of a tab, made for one type of message. */
export interface PanelOf<T extends MessageType> {
  type: T;
  /** Title of its tab. Cards of one tab stand in the registry's order, tabs in that of their first cards. */
  tab: Text;
  /** Null: no message has come yet. */
  Card: ComponentType<{ message: Message<T> | null }>;
  /** Whether it is there at all; without it: once a message has come. */
  offered?: (app: App, phone: boolean) => boolean;
  /** Shown beside the tab's title, unless 0. */
  badge?: (message: Message<T> | null) => string | number;
  /** Whether the tab asks to be looked at. */
  alarm?: (message: Message<T> | null) => boolean;
}

export type Panel = PanelOf<MessageType>;

/** Forgets which type the panel is of: the registry holds panels of all. */
export function panel<T extends MessageType>(made: PanelOf<T>): Panel {
  return made as unknown as Panel;
}

export interface Tab {
  id: string;
  title: string;
  badge: string | number;
  alarm: boolean;
  panels: Panel[];
}

/** Whether two lists of tabs look the same and hold the same panels. */
export function sameTabs(a: readonly Tab[], b: readonly Tab[]): boolean {
  const same = (one: Tab, other: Tab) =>
    one.id === other.id &&
    one.badge === other.badge &&
    one.alarm === other.alarm &&
    one.panels.length === other.panels.length &&
    one.panels.every((panel, i) => panel === other.panels[i]);
  return a.length === b.length && a.every((tab, i) => same(tab, b[i]!));
}

/** The tabs of `panels`, another list only when it is to be shown otherwise: most messages change none. */
export function offeredTabs(panels: readonly Panel[], app: App, phone: boolean): ReadonlySignal<readonly Tab[]> {
  let shown: readonly Tab[] = [];
  return computed(() => {
    const next = tabsOf(panels, app, phone);
    if (!sameTabs(shown, next)) shown = next;
    return shown;
  });
}

/** The tabs of `panels` that are offered. */
export function tabsOf(panels: readonly Panel[], app: App, phone: boolean): Tab[] {
  const tabs = new Map<string, Tab>();
  for (const one of panels) {
    const message = app.store.of(one.type).value;
    if (!(one.offered ? one.offered(app, phone) : message !== null)) continue;
    const id = one.tab.toLowerCase();
    const tab = tabs.get(id) ?? { id, title: t(one.tab), badge: 0, alarm: false, panels: [] };
    tabs.set(id, tab);
    tab.panels.push(one);
    tab.badge ||= one.badge?.(message) ?? 0;
    tab.alarm ||= one.alarm?.(message) ?? false;
  }
  return [...tabs.values()];
}
