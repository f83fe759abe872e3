/** The page's one store: what the robot last said, and what this page is showing. Fed by `session.ts`. */

import { computed, type ReadonlySignal, signal } from "@preact/signals";
import type { SoftLimit } from "../drive/viewFollow";
import { LaneHistory } from "../lanes/history";
import type { Hello, LaneRow, Load, NoticeLevel, Playback, Recordings, RobotEvent } from "../protocol/types";
import { bodyOf } from "./body";
import { Latest, type MessageType } from "./latest";
import { attendedCpu } from "./load";
import { PageClock } from "./pageClock";

export type Phase = "connecting" | "live" | "stale" | "lost" | "login";
/** How a picture over the 3D view is shown. */
export type InsetMode = "inset" | "large" | "hidden";
/** Where the map is: beside the view, in its tab; or over all of the view. */
export type MapPlace = "tab" | "view";

export interface LinkView {
  phase: Phase;
  /** The page's clock (ms) at which the next attempt starts. */
  retryAt: number;
}

export interface Notice {
  id: number;
  level: NoticeLevel;
  text: string;
  /** "en": it is as the program says it, on a page of another language. */
  lang: "en" | undefined;
  until: number;
}

/** One figure a second, newest last, for the load plot. */
export interface LoadPoint {
  stamp: number;
  /** The whole process, and the part that attention governs; % of a core. */
  cpu: number;
  attended: number;
  budget: number | null;
}

type RoleName = Hello["role"];

const EVENTS_KEPT = 1000;
const LOAD_KEPT = 600;
const NOTICES_SHOWN = 4;
const OPERATOR_KEY = "hbba.operator";

export function createStore() {
  const hello = signal<Hello | null>(null);
  const now = signal<number | null>(null);
  const latest = new Latest();
  const of = <T extends MessageType>(type: T) => latest.of(type);
  const status = of("status");
  const link = signal<LinkView>({ phase: "connecting", retryAt: 0 });
  const events = signal<RobotEvent[]>([]);
  const loadHistory = signal<LoadPoint[]>([]);
  const notices = signal<Notice[]>([]);
  const popups: (() => void)[] = [];
  const playback = signal<Playback | null>(null);
  const lanes = new LaneHistory();
  const operator = signal(readOperator() ?? "operator");
  const named = signal(readOperator() !== null);
  const live = computed(() => link.value.phase === "live") as ReadonlySignal<boolean>;
  let noticeId = 0;

  return {
    clock: new PageClock(),
    lanes,
    link,
    hello,
    /** What this robot can do: what it cannot is not offered. */
    body: computed(() => bodyOf(hello.value)),
    latest,
    /** The newest message of a type, null where there is none. */
    of,
    stopped: computed(() => status.value?.guard.e_stopped === true) as ReadonlySignal<boolean>,
    /** The lanes as they are now, one per desire class. */
    rows: computed(() => of("lanes").value?.rows ?? []) as ReadonlySignal<LaneRow[]>,
    loadHistory,
    /** Where this page shows a recording: its transport. Null: a living robot. */
    playback,
    replay: computed(() => playback.value !== null) as ReadonlySignal<boolean>,
    mapPlace: signal<MapPlace>("tab"),
    /** The list last read; null: not yet. */
    recordings: signal<Recordings | null>(null),
    /** Whether the list is looked at. */
    recordingsShown: signal(false),
    events,
    eventsKnown: signal(false),
    notices,
    operator,
    /** Whether this browser has been given a name, or was asked for one. */
    named,
    /** What this page may do, by its login. */
    role: computed(() => hello.value?.role ?? "operator") as ReadonlySignal<RoleName>,
    /** Whether there is a login to end. */
    loggedIn: signal(false),
    rttMs: signal<number | null>(null),
    viewAgeMs: signal<number | null>(null),
    /** The robot's clock, refreshed four times a second: for "12 s ago". */
    now,
    /** The same, once a second: for long lists. */
    seconds: computed(() => (now.value === null ? null : Math.floor(now.value))) as ReadonlySignal<number | null>,
    /** Id of the side column's tab that is shown. */
    tab: signal("attention"),
    camera: signal<InsetMode>(sceneWanted() ? "inset" : "large"),
    /** The strip of all directions around the robot. On a phone its small form is in the tab. */
    around: signal<InsetMode>("inset"),
    /** Of the head that follows the 3D view; null: it does not. */
    softLimit: signal<SoftLimit | null>(null),
    /** Whether what stands out is shown on it. */
    salient: signal(true),
    /** Whether the 3D view is drawn at all. */
    scene: signal(sceneWanted()),
    /** Whether it has come. */
    sceneShown: signal(false),
    help: signal(false),
    /** Each closes what is open over the page, the newest last: Escape takes one after another. */
    popups,
    /** Whether the lanes have the whole window. */
    lanesLarge: signal(false),
    live,
    /** Whether nothing drives the robot, by what is heard of it now. */
    stands: computed(() => live.value && status.value?.guard.state === "idle") as ReadonlySignal<boolean>,
    /** Whether someone has the wheel, or the robot moves: what its pictures show changes, and a hand answers to it. */
    steered: computed(
      () => status.value === null || status.value.driver !== null || status.value.guard.state !== "idle",
    ) as ReadonlySignal<boolean>,

    addEvents(fresh: RobotEvent[]): void {
      // A robot that was restarted counts from the beginning again: the stamp distinguishes its events.
      const key = (event: RobotEvent) => `${event.id}@${event.stamp}`;
      const known = new Set(events.value.map(key));
      const added = fresh.filter((event) => !known.has(key(event)));
      if (added.length === 0) return;
      const all = [...events.value, ...added].sort((a, b) => a.stamp - b.stamp);
      events.value = all.slice(-EVENTS_KEPT);
    },
    addLoad(load: Load): void {
      const point = {
        stamp: load.stamp,
        cpu: load.process_cpu,
        attended: attendedCpu(load, of("intention").value),
        budget: load.budget,
      };
      loadHistory.value = [...loadHistory.value.slice(1 - LOAD_KEPT), point];
    },
    /** A recording went to another place: what was shown belongs to the old one. */
    forget(): void {
      lanes.clear();
      events.value = [];
      loadHistory.value = [];
    },
    /** Something opened over the page, which `close` closes. What comes back says that it is closed. */
    opened(close: () => void): () => void {
      const popup = () => close();
      popups.push(popup);
      return () => {
        const at = popups.indexOf(popup);
        if (at >= 0) popups.splice(at, 1);
      };
    },
    /** At once, before it is drawn: the next Escape is of what is open below it, or stops the robot. */
    closeNewest(): void {
      popups.pop()?.();
    },
    notify(level: NoticeLevel, text: string, lang?: "en"): void {
      const until = performance.now() + (level === "info" ? 5000 : 9000);
      const others = notices.value.filter((notice) => notice.text !== text);
      notices.value = [...others, { id: ++noticeId, level, text, lang, until }].slice(-NOTICES_SHOWN);
    },
    showScene(shown: boolean): void {
      this.scene.value = shown;
      this.camera.value = shown ? "inset" : "large";
      this.mapPlace.value = "tab";
      if (!shown && this.around.value === "large") this.around.value = "inset";
    },
    /** Over all of the view is room for one. */
    showCamera(mode: InsetMode): void {
      this.camera.value = mode;
      if (mode === "large") this.mapPlace.value = "tab";
      if (mode === "large" && this.around.value === "large") this.around.value = "inset";
    },
    showAround(mode: InsetMode): void {
      this.around.value = mode;
      if (mode === "large") this.mapPlace.value = "tab";
      if (mode === "large" && this.camera.value === "large") this.camera.value = "inset";
    },
    showMap(place: MapPlace): void {
      this.mapPlace.value = place;
      this.tab.value = "map";
      if (place === "tab") {
        if (!this.scene.value) this.camera.value = "large"; // as the view would be empty else
        return;
      }
      if (this.around.value === "large") this.around.value = "inset";
      if (this.camera.value === "large") this.camera.value = "inset";
    },
    /** What tours are edited with: the map large, the stops beside it. A phone has room for one: the stops, or the map. */
    showTour(place: MapPlace): void {
      this.showMap(place);
      this.tab.value = "tour";
    },
    dismiss(id: number): void {
      notices.value = notices.value.filter((notice) => notice.id !== id);
    },
    rename(name: string): void {
      operator.value = name.trim().slice(0, 40) || "operator";
      named.value = true;
      localStorage.setItem(OPERATOR_KEY, operator.value);
    },
  };
}

/** `?scene=off` in the page's address opens it without the 3D view. */
function sceneWanted(): boolean {
  return typeof location === "undefined" || new URLSearchParams(location.search).get("scene") !== "off";
}

/** Null: this browser has been given no name. */
function readOperator(): string | null {
  return typeof localStorage === "undefined" ? null : localStorage.getItem(OPERATOR_KEY);
}

export type Store = ReturnType<typeof createStore>;
