/** One connection to `/api/v1/live`: opens, pings, watches, and opens again with back-off when it is lost. */

import type { FromRobot, Timed, ToRobot } from "./types";

export interface LiveHandlers {
  opened(): void;
  message(message: FromRobot): void;
  /** A picture or a piece of sound. */
  binary(frame: ArrayBuffer): void;
  roundTrip(rttMs: number): void;
  /** The connection is gone; the next attempt comes in `retryInMs`. `everOpened`: it had stood. */
  lost(everOpened: boolean, retryInMs: number): void;
}

/** Under the second after which the robot gives up on a page that says nothing. */
const PING_MS = 800;
const SILENCE_MS = 4000;
const FIRST_RETRY_MS = 400;
const LAST_RETRY_MS = 5000;
/** Above this much unsent, a held drive command would arrive late: it is left out, the next one is newer. */
const BACKLOG_BYTES = 16_384;
/** What may move something says when it was sent; a ping does, too, so that the robot knows how late it comes. */
const TIMED: ReadonlySet<ToRobot["type"]> = new Set([
  "drive",
  "look",
  "clear_e_stop",
  "take_control",
  "ask_control",
  "ping",
]);

export class LiveConnection {
  private socket: WebSocket | null = null;
  private timers: number[] = [];
  private retryTimer = 0;
  private attempt = 0;
  private lastHeard = 0;
  private rttMs: number | null = null;
  /** The robot's newest stamp on this connection, and when it came. */
  private heard: Omit<Timed, "t"> = {};
  private closed = false;

  constructor(
    private readonly address: () => string,
    private readonly handlers: LiveHandlers,
  ) {}

  open(): void {
    this.closed = false;
    clearTimeout(this.retryTimer);
    this.drop();
    const socket = new WebSocket(this.address());
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.lastHeard = performance.now();
    this.heard = {};
    let stood = false;
    socket.onopen = () => {
      stood = true;
      this.attempt = 0;
      this.handlers.opened();
      this.ping();
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.receive(event.data);
    socket.onclose = () => {
      if (this.socket === socket) this.lose(stood);
    };
    this.timers = [window.setInterval(() => this.ping(), PING_MS), window.setInterval(() => this.watch(), 500)];
  }

  /** Closes for good; `open` starts again. */
  close(): void {
    this.closed = true;
    clearTimeout(this.retryTimer);
    this.drop();
  }

  /** True if it went to the socket. */
  send(message: ToRobot): boolean {
    const socket = this.socket;
    if (!socket || socket.readyState !== WebSocket.OPEN) return false;
    if (message.type === "drive" && message.held && socket.bufferedAmount > BACKLOG_BYTES) return false;
    const times = TIMED.has(message.type) ? { t: performance.now(), ...this.heard } : {};
    socket.send(JSON.stringify({ ...message, ...times }));
    return true;
  }

  /** Sends a binary frame. True if it went to the socket: sound that would come late is left out. */
  sendBinary(frame: ArrayBuffer): boolean {
    const socket = this.socket;
    if (!socket || socket.readyState !== WebSocket.OPEN || socket.bufferedAmount > BACKLOG_BYTES) return false;
    socket.send(frame);
    return true;
  }

  private receive(data: string | ArrayBuffer): void {
    this.lastHeard = performance.now();
    if (typeof data !== "string") {
      this.handlers.binary(data);
      return;
    }
    const message = JSON.parse(data) as FromRobot;
    if (message.type === "hello" || message.type === "status" || message.type === "pong")
      this.heard = { heard: message.stamp, heard_t: this.lastHeard };
    if (message.type === "pong" && message.t !== null) {
      this.rttMs = performance.now() - message.t;
      this.handlers.roundTrip(this.rttMs);
    }
    this.handlers.message(message);
  }

  private ping(): void {
    this.send({ type: "ping", rtt_ms: this.rttMs });
  }

  /** A cable pulled leaves a socket that looks open: silence is a loss. */
  private watch(): void {
    if (this.socket && performance.now() - this.lastHeard > SILENCE_MS) {
      const stood = this.socket.readyState === WebSocket.OPEN;
      this.drop();
      this.lose(stood);
    }
  }

  private lose(stood: boolean): void {
    this.drop();
    if (this.closed) return;
    const wait = Math.min(LAST_RETRY_MS, FIRST_RETRY_MS * 2 ** this.attempt) * (0.8 + 0.4 * Math.random());
    this.attempt += 1;
    this.rttMs = null;
    this.handlers.lost(stood, wait);
    this.retryTimer = window.setTimeout(() => this.open(), wait);
  }

  private drop(): void {
    this.timers.forEach((timer) => clearInterval(timer));
    this.timers = [];
    const socket = this.socket;
    this.socket = null;
    if (socket && socket.readyState <= WebSocket.OPEN) socket.close();
  }
}
