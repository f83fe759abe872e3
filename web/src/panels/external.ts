/**
 * Panels of packages: ES modules served under /panels/, each in a tab of its own.
 *
 * A module's default export is called with the element that is the panel's and with `{on}`: `on(kind, handler)` calls
 * `handler` with each frame of a kind that the panel named (`status`, `channel/NAME`), the newest one first if there was
 * any, and returns what ends that. What the export returns, if anything, is called when the panel is closed.
 */

import { signal } from "@preact/signals";
import { h } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import type { FromRobot } from "../protocol/types";
import type { Session } from "../state/session";
import type { Store } from "../state/store";
import type { TabItem } from "../ui/Tabs";

export interface PanelEntry {
  name: string;
  title: string;
  url: string;
  kinds: string[];
}

export type Handler = (frame: FromRobot) => void;

export interface PanelContext {
  on(kind: string, handler: Handler): () => void;
}

export type Mount = (element: HTMLElement, context: PanelContext) => (() => void) | undefined;

/** Hands frames to panels: each panel gets those of its kinds alone. */
export class PanelFrames {
  private readonly handlers = new Map<string, Set<Handler>>();
  private readonly newest = new Map<string, FromRobot>();
  private readonly kinds = new Set<string>();

  /** Begin to keep the newest frame of `kinds`. */
  want(kinds: readonly string[]): void {
    for (const kind of kinds) this.kinds.add(kind);
  }

  take(frame: FromRobot): void {
    if (frame.type === "jump") this.newest.clear();
    const kind = frame.type === "channel" ? `channel/${frame.channel}` : frame.type;
    if (!this.kinds.has(kind)) return;
    this.newest.set(kind, frame);
    for (const handler of this.handlers.get(kind) ?? []) handler(frame);
  }

  /** What a panel of `entry` is given; `end` ends all its handlers. */
  context(entry: PanelEntry): PanelContext & { end(): void } {
    const ends: (() => void)[] = [];
    return {
      on: (kind, handler) => {
        if (!entry.kinds.includes(kind))
          throw new Error(`the panel ${entry.name} does not name ${kind} among its kinds: ${entry.kinds.join(", ")}`);
        const handlers = this.handlers.get(kind) ?? new Set();
        this.handlers.set(kind, handlers.add(handler));
        const newest = this.newest.get(kind);
        if (newest) handler(newest);
        const end = () => void handlers.delete(handler);
        ends.push(end);
        return end;
      },
      end: () => ends.forEach((end) => end()),
    };
  }
}

const entries = signal<readonly PanelEntry[]>([]);
const frames = new PanelFrames();
const followed = new WeakSet<Session>();

/** The tabs of the panels that packages bring; none until the console has listed them. */
export function externalTabs({ session, store }: { session: Session; store: Store }): TabItem[] {
  follow(session, store);
  return entries.value.map((entry) => ({
    id: `panel-${entry.name}`,
    title: entry.title,
    content: () => h(ExternalPanel, { key: entry.name, entry, store }),
  }));
}

function follow(session: Session, store: Store): void {
  if (followed.has(session)) return;
  followed.add(session);
  session.onFrame.add((frame) => frames.take(frame));
  const list = () =>
    void listed().then(
      (found) => {
        frames.want(found.flatMap((entry) => entry.kinds));
        entries.value = found;
      },
      (problem: Error) =>
        store.notify("warning", t("The panels of packages cannot be listed: {problem}", { problem: problem.message })),
    );
  session.onHello.add(list);
  if (store.hello.peek()) list();
}

/** The page may be served below another path. */
function address(url: string): string {
  return new URL(url, document.baseURI).href;
}

async function listed(): Promise<PanelEntry[]> {
  const answer = await fetch(address("panels/index.json"), { credentials: "same-origin" });
  if (!answer.ok) throw new Error(t("the console answered {status}", { status: answer.status }));
  return (await answer.json()) as PanelEntry[];
}

function ExternalPanel({ entry, store }: { entry: PanelEntry; store: Store }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const context = frames.context(entry);
    let unmount: (() => void) | undefined;
    let closed = false;
    void load(entry)
      .then((mount) => {
        if (!closed) unmount = mount(place.current!, { on: context.on });
      })
      .catch((problem: Error) =>
        store.notify(
          "error",
          t("The panel {title} cannot be shown: {problem}", { title: entry.title, problem: problem.message }),
        ),
      );
    return () => {
      closed = true;
      context.end();
      unmount?.();
    };
  }, [entry.url]);
  return h("section", { class: "card", "aria-label": entry.title, "data-testid": `panel-${entry.name}`, ref: place });
}

async function load(entry: PanelEntry): Promise<Mount> {
  const module = (await import(/* @vite-ignore */ address(entry.url))) as { default?: unknown };
  if (typeof module.default !== "function") throw new Error(`${entry.url} has no default export that is a function`);
  return module.default as Mount;
}
