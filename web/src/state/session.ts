/** Joins the connection to the store: newest message of each kind once per turn, staleness, login, clocks. */

import { batch } from "@preact/signals";
import type { StopOrder } from "../drive/stopWorker";
import { t } from "../i18n";
import { LiveConnection } from "../protocol/live";
import { Problem } from "../protocol/problem";
import { Requests } from "../protocol/requests";
import { Rest } from "../protocol/rest";
import { tokenIn } from "../protocol/token";
import { TourRest } from "../protocol/tourRest";
import type { FromRobot, Hello, Playback, ToRobot } from "../protocol/types";
import { isFresh } from "./freshness";
import type { Message, MessageType } from "./latest";
import type { Store } from "./store";
import { fourTimesASecond, nextTurn } from "./turns";
import { urgent } from "./urgency";

const WATCH_MS = 100;
const READ_MS = 40;
const HISTORY_EVENTS = 200;
/** So soon after a greeting or a jump everything has come again; the rarest, the load, comes once a second. */
const AGAIN_MS = 1500;

export class Session {
  readonly rest: Rest;
  readonly tourRest: TourRest;
  /** Called with each binary frame of a kind, at arrival. */
  readonly onBinary = new Map<number, (frame: ArrayBuffer) => void>();
  /** Called at every chance the page gets: each turn, each message. Timers starve first when it is busy drawing. */
  onChance: () => void = () => undefined;
  /** Called when the robot has greeted a new connection. */
  readonly onHello = new Set<() => void>();
  /** Called with each text frame, at arrival: panels of packages. */
  readonly onFrame = new Set<(message: FromRobot) => void>();
  /** Called when a recording has gone to another place. */
  readonly onJump = new Set<() => void>();
  private readonly live: LiveConnection;
  private readonly handlers = new Map<MessageType, (message: FromRobot) => void>();
  private readonly waiting = new Map<MessageType, FromRobot>();
  private lastStatusAt = 0;
  private lastHeardAt = 0;
  private watchedAt = 0;
  private outdatedUntil = 0;
  private stopOwed = false;
  /** A turn is due. */
  private turning = false;

  /** `orderStop` sends the emergency stop by its own path, beside the live stream. */
  constructor(
    private readonly store: Store,
    private readonly orderStop: (order: StopOrder) => void = () => undefined,
  ) {
    const requests = new Requests(() => store.operator.value);
    this.rest = new Rest(requests);
    this.tourRest = new TourRest(requests);
    this.live = new LiveConnection(() => liveAddress(store.operator.value), {
      opened: () => this.opened(),
      message: (message) => this.receive(message),
      binary: (frame) => this.receiveBinary(frame),
      roundTrip: (rttMs) => this.roundTrip(rttMs),
      lost: (everOpened, retryInMs) => this.lost(everOpened, retryInMs),
    });
  }

  /** Calls `handler` with each message of a type, at arrival; the newest is in the store at the next turn all the same. */
  on<T extends MessageType>(type: T, handler: (message: Message<T>) => void): void {
    this.handlers.set(type, handler as (message: FromRobot) => void);
  }

  async start(): Promise<void> {
    window.setInterval(() => this.watch(), WATCH_MS);
    fourTimesASecond(() => this.refresh());
    await this.enter();
  }

  /** Asks whether we may, then connects; shows the login when we may not and the address holds no token that opens. */
  async enter(): Promise<void> {
    if ((await this.refused()) && !(await this.logInByAddress()))
      this.store.link.value = { phase: "login", retryAt: 0 };
    else this.live.open();
  }

  async logIn(token: string): Promise<void> {
    await this.rest.logIn(token);
    this.store.loggedIn.value = true;
    this.store.link.value = { phase: "connecting", retryAt: 0 };
    this.live.open();
  }

  async logOut(): Promise<void> {
    this.live.close();
    await this.rest.logOut();
    batch(() => {
      this.store.loggedIn.value = false;
      this.store.link.value = { phase: "login", retryAt: 0 };
    });
  }

  /** Greets the robot under the operator's new name: a driver's robot stops for it. */
  rename(name: string): void {
    if (name.trim() === this.store.operator.peek()) {
      this.store.rename(name);
      return;
    }
    this.store.rename(name);
    if (this.store.link.peek().phase === "live") this.live.open();
  }

  send(message: ToRobot): boolean {
    return this.live.send(message);
  }

  /** True if it went to the socket. */
  sendBinary(frame: ArrayBuffer): boolean {
    return this.live.sendBinary(frame);
  }

  /** Sends the emergency stop; without a connection, it is sent first thing on the next. */
  eStop(): void {
    this.orderStop({ url: new URL("./api/v1/stop", location.href).href, operator: this.store.operator.peek() });
    if (this.send({ type: "e_stop" })) return;
    this.stopOwed = true;
    this.store.notify(
      "error",
      t("Not connected: the emergency stop is sent when the robot answers. Without commands it stops by itself."),
    );
  }

  clearEStop(): void {
    this.stopOwed = false;
    this.send({ type: "clear_e_stop" });
  }

  private async logInByAddress(): Promise<boolean> {
    const token = tokenIn(location.hash);
    if (token === null) return false;
    // Not to be left in the history, nor in a link that is copied.
    history.replaceState(null, "", location.pathname + location.search);
    try {
      await this.rest.logIn(token);
      return true;
    } catch {
      return false;
    }
  }

  private async refused(): Promise<boolean> {
    try {
      this.store.loggedIn.value = (await this.rest.session()).token_needed;
      return false;
    } catch (problem) {
      return problem instanceof Problem && problem.status === 401;
    }
  }

  private opened(): void {
    if (this.stopOwed && this.send({ type: "e_stop" })) this.stopOwed = false;
    void this.rest.timeline(HISTORY_EVENTS).then(
      (events) => {
        this.store.addEvents(events);
        this.store.eventsKnown.value = true;
      },
      () => (this.store.eventsKnown.value = true),
    );
  }

  private receiveBinary(frame: ArrayBuffer): void {
    if (frame.byteLength > 0) this.onBinary.get(new Uint8Array(frame, 0, 1)[0]!)?.(frame);
  }

  private receive(message: FromRobot): void {
    const at = performance.now();
    this.onChance();
    this.lastHeardAt = at;
    this.onFrame.forEach((handler) => handler(message));
    if (message.type === "channel") return;
    if (message.type === "hello") this.store.clock.begin(message.playback, at / 1000);
    if (message.type === "playback") this.store.clock.played(message, at / 1000);
    if (message.type === "jump") this.jump();
    if ("stamp" in message && typeof message.stamp === "number" && message.type !== "load")
      this.store.clock.heard(message.stamp, at / 1000);
    if (message.type === "status") this.lastStatusAt = at;
    this.handlers.get(message.type)?.(message);
    if (message.type === "hello") this.greet(message);
    else if (message.type !== "jump") this.keep(message);
  }

  private keep(message: FromRobot): void {
    const { store } = this;
    this.waiting.set(message.type, message);
    if (urgent(message, store.of("status").peek(), store.live.peek())) this.apply();
    else if (!this.turning) {
      this.turning = true;
      nextTurn(() => {
        this.turning = false;
        this.onChance();
        this.apply();
      });
    }
  }

  private greet(hello: Hello): void {
    this.outdate();
    batch(() => {
      this.store.hello.value = hello;
      this.store.playback.value = hello.playback;
    });
    this.onHello.forEach((handler) => handler());
  }

  /** All that is known is sent again after a greeting and after a jump; what is not is of before, and void. */
  private outdate(): void {
    this.waiting.clear();
    this.store.latest.outdate();
    this.outdatedUntil = performance.now() + AGAIN_MS;
  }

  /** What came since the last turn, newest of each kind, in one batch. */
  private apply(): void {
    if (this.waiting.size === 0) return;
    const { store } = this;
    batch(() => {
      for (const message of this.waiting.values()) store.latest.put(message);
      if (this.waiting.has("playback")) store.playback.value = this.waiting.get("playback") as Playback;
      const reported = this.waiting.has("status");
      this.waiting.clear();
      // Of a robot its status alone shows that it is there; a paused recording has nothing new to send.
      const there = store.replay.peek() || reported;
      if (there && store.link.value.phase !== "live" && this.fresh()) store.link.value = { phase: "live", retryAt: 0 };
    });
  }

  private roundTrip(rttMs: number): void {
    this.store.rttMs.value = rttMs;
    this.store.clock.roundTrip(rttMs / 1000, performance.now() / 1000);
  }

  private fresh(): boolean {
    const at = performance.now();
    return isFresh({ status: at - this.lastStatusAt, anything: at - this.lastHeardAt }, this.store.replay.peek());
  }

  private jump(): void {
    this.outdate();
    batch(() => this.onJump.forEach((handler) => handler()));
  }

  /** A page that was busy itself reads first what came meanwhile, before it says that nothing came. */
  private watch(): void {
    const at = performance.now();
    const late = at - this.watchedAt > 2 * WATCH_MS;
    this.watchedAt = at;
    if (late) window.setTimeout(() => this.judge(), READ_MS);
    else this.judge();
  }

  private judge(): void {
    const link = this.store.link.value;
    if (link.phase === "live" && !this.fresh()) this.store.link.value = { ...link, phase: "stale" };
  }

  private refresh(): void {
    const at = performance.now();
    const { store } = this;
    batch(() => {
      if (at >= this.outdatedUntil) store.latest.dropOutdated();
      store.now.value = store.clock.now(at / 1000);
      const shown = store.of("status").value?.stamp;
      const now = store.now.value;
      store.viewAgeMs.value = shown !== undefined && now !== null ? Math.max(0, (now - shown) * 1000) : null;
      if (store.notices.value.some((notice) => notice.until < at)) {
        store.notices.value = store.notices.value.filter((notice) => notice.until >= at);
      }
    });
  }

  private lost(everOpened: boolean, retryInMs: number): void {
    const { store } = this;
    this.waiting.clear(); // a status that came before the loss does not show that the robot is there
    const phase = store.hello.value ? "lost" : "connecting";
    store.link.value = { phase, retryAt: performance.now() + retryInMs };
    store.rttMs.value = null;
    if (everOpened) return;
    // A refused handshake looks like a dead robot: ask which it is.
    void this.refused().then((refused) => {
      if (!refused) return;
      this.live.close();
      store.link.value = { phase: "login", retryAt: 0 };
    });
  }
}

function liveAddress(operator: string): string {
  const address = new URL("./api/v1/live", location.href);
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  address.search = new URLSearchParams({ operator }).toString();
  address.hash = "";
  return address.href;
}
