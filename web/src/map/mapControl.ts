/** Everything the page does with the map: its tools, what is shown of it, and the requests to the robot. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { typesText } from "../drive/driveController";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { Desire, GoalRequest, LocalizationReport, PoseReport, Zone } from "../protocol/types";
import type { Session } from "../state/session";
import type { MapPlace, Store } from "../state/store";
import { around, freeOf } from "./fitting";
import type { GridPicture } from "./gridFeed";
import {
  composed,
  FIRST_VIEW,
  fitted,
  type MapView,
  NORTH,
  type Point,
  type Pose,
  type Size,
  zoomed,
} from "./mapProjection";
import { EXPLORE, explorationsOf, goalOf, isAsked, tripsOf } from "./mapText";
import { AT_REST, busy, type Input, type Sight, step, type Tool, type Tools, type Wish } from "./mapTools";
import {
  added,
  cornerMoved,
  cornersOf,
  edited,
  type History,
  NO_HISTORY,
  polygonProblem,
  same,
  undoable,
  undone,
  zoneAt,
} from "./zoneList";

/** What the robot was asked for and has not answered yet. */
export type Pending = "goal" | "cancel" | "pose" | "search" | "zones" | "desire" | null;

export class MapControl {
  readonly tools = signal<Tools>(AT_REST);
  readonly view = signal<MapView>(FIRST_VIEW);
  readonly follow = signal(true);
  readonly robotUp = signal(false);
  readonly costmap = signal(false);
  /** Name of the zone that is selected. */
  readonly selected = signal<string | null>(null);
  readonly pending = signal<Pending>(null);
  /** Why the last thing asked for was refused; empty: it was not. */
  readonly problem = signal("");
  /** The robot on the map: by the last localization and odometry since. */
  readonly robot: ReadonlySignal<Pose | null>;
  /** As the robot has them, or as they were just edited. */
  readonly zones: ReadonlySignal<readonly Zone[]>;
  readonly shown: ReadonlySignal<boolean>;
  /** The keyboard is to come to the canvas as soon as that is there. */
  readonly called = signal(false);
  /** Called with the place (m) that is clicked with the tool `point`. */
  onPoint: (at: Point) => void = () => undefined;
  /** Called with a click (m) that no tool takes, and px a metre; returns whether something is there that takes it. */
  onSelect: (at: Point, scale: number) => boolean = () => false;
  /** Whether the robot can be asked for anything. */
  readonly allowed: ReadonlySignal<boolean>;
  private readonly edits = signal<readonly Zone[] | null>(null);
  private readonly history = signal<History>(NO_HISTORY);
  private size: Size = { width: 0, height: 0 };
  private on: MapPlace = "tab";
  private fresh = true;
  /** The last goal that was asked for, on its way to the robot. */
  private sending: Promise<unknown> = Promise.resolve();

  constructor(
    private readonly store: Store,
    private readonly session: Session,
  ) {
    this.robot = computed(() => robotOn(store.of("localization").value, store.of("status").value?.odometry ?? null));
    this.zones = computed(() => this.edits.value ?? store.of("zones").value?.zones ?? []);
    this.shown = computed(
      () => store.body.value.maps && (store.mapPlace.value === "view" || store.tab.value === "map"),
    );
    this.allowed = computed(() => store.live.value && !store.replay.value);
  }

  start(): void {
    effect(() => {
      // What the robot says now is what counts, once it says what was asked for.
      const sent = this.store.of("zones").value?.zones;
      const asked = this.edits.peek();
      if (asked && sent && same(asked, sent)) this.edits.value = null;
    });
    effect(() => {
      const names = this.zones.value.map((zone) => zone.name);
      if (this.selected.value !== null && !names.includes(this.selected.value)) this.selected.value = null;
    });
    effect(() => {
      const robot = this.robot.value;
      const view = this.view.peek();
      const up = this.robotUp.value ? (robot?.theta ?? view.up) : NORTH;
      const middle = this.follow.value && robot ? robot : view;
      this.view.value = { ...view, x: middle.x, y: middle.y, up };
    });
    // Before the driving keys: Escape cancels the map's tool first, while the robot stands.
    window.addEventListener("keydown", (event) => this.keyDown(event), { capture: true });
  }

  /** The canvas has so many px now, and is there now: what was seen in one place is seen in the other. */
  resize(size: Size, place: MapPlace): void {
    const before = this.size;
    this.size = size;
    if (place === this.on) return;
    this.on = place;
    if (before.width === 0 || size.width === 0) return;
    const factor = Math.min(size.width / before.width, size.height / before.height);
    this.view.value = zoomed(this.view.peek(), size, factor);
  }

  get sight(): Sight {
    return { view: this.view.peek(), size: this.size, follow: this.follow.peek() && this.robot.peek() !== null };
  }

  input(input: Input): boolean {
    const { tools, view, wish, panned, taken } = step(this.tools.peek(), input, this.sight);
    if (panned) this.follow.value = false;
    this.tools.value = tools;
    this.view.value = view;
    if (wish) void this.grant(wish);
    return taken;
  }

  /** Shows the map and brings the keyboard to it. */
  call(): void {
    if (!this.shown.peek()) this.store.tab.value = "map";
    this.called.value = true;
  }

  /** A tool that is chosen again is put away. */
  choose(tool: Tool): void {
    this.problem.value = "";
    this.input({ type: "tool", tool: this.tools.peek().tool === tool ? "look" : tool });
  }

  zoom(factor: number): void {
    this.view.value = zoomed(this.view.peek(), this.size, factor);
  }

  fit(map: GridPicture | null): void {
    this.follow.value = false;
    const { of, replay } = this.store;
    const path = of("navigation").peek()?.path ?? [];
    const marks = [this.robot.peek(), goalOf(of("desires").peek()?.desires), ...path.map(([x, y]) => ({ x, y }))];
    const bounds = around(
      map?.known ?? null,
      marks.filter((mark) => mark !== null),
    );
    if (!bounds) return;
    this.view.value = fitted(this.view.peek(), this.size, bounds, freeOf(this.on, this.size, !replay.peek()));
  }

  /** The first picture on which anything is known is shown wholly. */
  met(map: GridPicture | null): void {
    if (!map?.known || !this.fresh || this.size.width === 0) return;
    this.fresh = false;
    const following = this.follow.peek();
    this.fit(map);
    this.follow.value = following;
  }

  async goTo(x: number, y: number, heading: number | null): Promise<void> {
    await this.send({ x, y, ...(heading === null ? {} : { heading }) });
  }

  /** To where the place with this id is now. */
  async goToPlace(id: string): Promise<void> {
    await this.send({ place: id });
  }

  private async send(goal: GoalRequest): Promise<void> {
    this.sending = this.ask("goal", () => this.session.rest.setGoal(goal));
    await this.sending;
  }

  /** To where the map began. */
  async returnToStart(): Promise<void> {
    if (this.allowed.peek() && this.store.body.peek().goes) await this.goTo(0, 0, 0);
  }

  async cancelGoal(): Promise<void> {
    const goal = goalOf(this.store.of("desires").peek()?.desires);
    const { rest } = this.session;
    await this.ask("cancel", () => (!goal || goal.asked ? rest.cancelGoal() : rest.removeDesire(goal.id)));
  }

  /** Ends every trip, of any source: with one ended, the robot might set out on the next. Returns whether there is any. */
  stop(): boolean {
    const sending = this.pending.peek() === "goal";
    const desires = this.store.of("desires").peek()?.desires;
    const trips = tripsOf(desires);
    const any = trips.length > 0 || explorationsOf(desires).length > 0 || sending;
    if (any) void this.endAll(trips);
    return any;
  }

  private async endAll(trips: readonly Desire[]): Promise<void> {
    await this.sending; // or the goal would come after its end
    const { rest } = this.session;
    const ended = await this.ask("cancel", async () => {
      await rest.cancelGoal(); // and exploring
      for (const trip of trips) if (!isAsked(trip)) await rest.removeDesire(trip.id);
    });
    if (ended) this.store.notify("info", t("The goal is cancelled."));
  }

  async place(pose: PoseReport): Promise<void> {
    await this.ask("pose", () => this.session.rest.placeRobot(pose));
  }

  async search(): Promise<void> {
    await this.ask("search", () => this.session.rest.searchRobot());
  }

  /** Adds a desire for SLAM unless there is one. */
  async desireMap(): Promise<void> {
    if (this.store.rows.peek().find((row) => row.class === "SLAM")?.state !== "undesired") return;
    const wish = { class: "SLAM", intensity: 6, utility: 1 };
    await this.ask("desire", () => this.session.rest.addDesire(wish, `slam-${Date.now()}`));
  }

  /** Has the robot explore what the map does not have, or ends that. */
  async explore(): Promise<void> {
    const { rest } = this.session;
    const explorations = explorationsOf(this.store.of("desires").peek()?.desires);
    const wish = { class: EXPLORE, intensity: 5, utility: 1 };
    await this.ask("desire", async () => {
      if (explorations.length === 0) await rest.addDesire(wish, `explore-${Date.now()}`);
      for (const exploration of explorations) await rest.removeDesire(exploration.id);
    });
  }

  get canUndo(): boolean {
    return undoable(this.history.value, this.zones.value) !== null;
  }

  async undo(): Promise<void> {
    const before = undoable(this.history.peek(), this.zones.peek());
    if (!before) return;
    const history = this.history.peek();
    this.history.value = undone(history);
    if (!(await this.mark(before))) this.history.value = history;
  }

  /** Resolves to whether the robot took them. */
  async editZones(zones: readonly Zone[]): Promise<boolean> {
    const before = this.zones.peek();
    const history = this.history.peek();
    this.history.value = edited(history, before, zones);
    if (await this.mark(zones)) return true;
    this.history.value = history;
    return false;
  }

  private async mark(zones: readonly Zone[]): Promise<boolean> {
    this.edits.value = zones;
    const taken = await this.ask("zones", () => this.session.rest.markZones(zones));
    if (!taken) this.edits.value = null;
    return taken;
  }

  private async grant(wish: Wish): Promise<void> {
    if (wish.type === "goal") return this.goTo(wish.place.x, wish.place.y, wish.heading);
    if (wish.type === "pose") {
      const theta = wish.heading ?? this.robot.peek()?.theta ?? 0;
      return this.place({ ...wish.place, theta });
    }
    if (wish.type === "point") return this.onPoint(wish.at);
    if (wish.type === "select" && this.onSelect(wish.at, this.view.peek().scale)) return;
    if (wish.type === "select") {
      this.selected.value = zoneAt(this.zones.peek(), wish.at)?.name ?? null;
      return;
    }
    const zones = this.zones.peek();
    const next =
      wish.type === "zone"
        ? added(zones, wish.kind, wish.polygon)
        : cornerMoved(zones, wish.handle.zone, wish.handle.index, wish.to);
    const touched = wish.type === "zone" ? next.at(-1) : next.find((zone) => zone.name === wish.handle.zone);
    const wrong = touched ? polygonProblem(cornersOf(touched)) : "";
    if (wrong) {
      this.problem.value = wrong;
      return;
    }
    const sent = this.editZones(next);
    if (touched) this.selected.value = touched.name;
    await sent;
  }

  private async ask(what: Pending, request: () => Promise<unknown>): Promise<boolean> {
    this.pending.value = what;
    this.problem.value = "";
    try {
      await request();
      return true;
    } catch (error) {
      this.problem.value = inWords(error).replace(FIELD, "");
      if (!this.shown.peek()) this.store.notify("error", this.problem.peek());
      return false;
    } finally {
      if (this.pending.peek() === what) this.pending.value = null;
    }
  }

  private keyDown(event: KeyboardEvent): void {
    if (event.code === "Escape") this.escape(event);
    else if (!this.store.body.peek().maps) return;
    else if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || typesText(event.target)) return;
    else if (event.code === "KeyM") this.store.showMap(this.store.mapPlace.peek() === "view" ? "tab" : "view");
    else if (event.code === "KeyG" && this.allowed.peek() && this.store.body.peek().goes) {
      this.choose("goal");
      if (this.tools.peek().tool === "goal") this.call();
    } else return;
    event.preventDefault();
  }

  /** The map's tool is cancelled first, as long as the robot stands; a moving robot is stopped in any case. */
  private escape(event: KeyboardEvent): void {
    const inUse = this.shown.peek() && busy(this.tools.peek());
    const stands = this.store.replay.peek() || this.store.stands.peek();
    if (inUse) this.input({ type: "key", key: "Escape", shift: false });
    const going = goalOf(this.store.of("desires").peek()?.desires) !== null;
    if (inUse && stands && !going) {
      event.preventDefault();
      event.stopImmediatePropagation();
    } else if (going) this.store.help.value = false; // or it would close the sheet instead of stopping
  }
}

export function robotOn(localization: LocalizationReport | null, odometry: Pose | null): Pose | null {
  if (!localization) return null;
  return odometry ? composed(localization.X_MO, odometry) : localization;
}

/** A corner of the selected zone under a point of the screen. */
export function handleAt(
  zones: readonly Zone[],
  selected: string | null,
  at: Point,
  toScreen: (point: Point) => Point,
) {
  const zone = zones.find(({ name }) => name === selected);
  if (!zone) return null;
  const index = cornersOf(zone).findIndex((corner) => {
    const { x, y } = toScreen(corner);
    return Math.hypot(x - at.x, y - at.y) <= HANDLE_PX;
  });
  return index < 0 ? null : { zone: zone.name, index };
}

const HANDLE_PX = 12;
/** The number of the wrong zone is left out: it is the one just drawn. */
const FIELD = /^zones\.\d+\.\w+\s?: /i;
