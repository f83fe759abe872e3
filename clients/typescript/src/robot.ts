/** The robot behind a console. */

import { Operations } from "./operations.js";
import type { Desire, LiveMessage, NewDesire } from "./records.js";
import { answerOf, initOf, liveUrl, Problem, type Request, Unreachable, urlOf } from "./request.js";

/** No pictures: they are for pages. */
const NO_PICTURES = { type: "view", camera: false, panorama: false, map: false, costmap: false };
/** Renewed so many times within its time to live: one lost renewal does not end a desire. */
const RENEWALS = 3;

/** A desire that is renewed until it is closed. */
export interface HeldDesire extends AsyncDisposable {
  readonly desire: Desire;
  /** Removes it from the robot; one that has left already is left alone. */
  close(): Promise<void>;
}

/** `token`: the console's, where it asks for one. `operator`: the name that others see. */
export interface RobotOptions {
  token?: string;
  operator?: string;
}

/** A console at `address`. Refusals are thrown as Problem, a console that does not answer as Unreachable. */
export class Robot extends Operations {
  readonly address: string;
  /** The newest version of what was read, by path, for `ifMatch`. */
  readonly etags = new Map<string, string>();
  readonly #operator: string | undefined;
  readonly #headers: Record<string, string> = {};

  constructor(address = "http://127.0.0.1:8080", { token, operator }: RobotOptions = {}) {
    super();
    this.address = address.replace(/\/+$/, "");
    this.#operator = operator;
    if (token) this.#headers.authorization = `Bearer ${token}`;
    if (operator) this.#headers["x-hbba-operator"] = encodeURIComponent(operator);
  }

  protected async ask<T>(request: Request): Promise<T> {
    let response: Response;
    try {
      response = await fetch(urlOf(this.address, request), initOf(request, this.#headers));
    } catch (error) {
      throw new Unreachable(`${this.address} does not answer`, { cause: error });
    }
    const etag = response.headers.get("etag");
    if (etag) this.etags.set(request.path, etag);
    return (await answerOf(request, response)) as T;
  }

  /**
   * Desire something until it is closed (`await using`, or `close`). The desire is renewed meanwhile; where this program
   * dies it expires within `ttl` seconds. One that the robot has accomplished, or somebody removed, is not created again.
   */
  async desire(
    desireClass: string,
    { ttl = 30, ...more }: { ttl?: number } & Partial<Omit<NewDesire, "class" | "ttl">> = {},
  ): Promise<HeldDesire> {
    if (!(ttl > 0)) throw new RangeError(`ttl is the seconds that the desire outlives its client, not ${ttl}`);
    const desire = await this.createDesire({ class: desireClass, intensity: 4, utility: 1, ...more, ttl });
    const renewing = setInterval(() => {
      this.changeDesire(desire.id, { ttl }).catch((error: unknown) => {
        if (!(error instanceof Unreachable)) clearInterval(renewing); // it has left
      });
    }, (1e3 * ttl) / RENEWALS);
    const close = async () => {
      clearInterval(renewing);
      try {
        await this.removeDesire(desire.id);
      } catch (error) {
        const gone = error instanceof Unreachable || (error instanceof Problem && error.status === 404);
        if (!gone) throw error;
      }
    };
    return { desire, close, [Symbol.asyncDispose]: close };
  }

  /**
   * The live stream's messages as they come, without pictures and sound; it closes when the loop is left. While it is
   * open the robot attends to telepresence, as for a page. A browser sends its session's cookie; a token cannot be sent.
   */
  async *live(): AsyncGenerator<LiveMessage, void, undefined> {
    const socket = new WebSocket(liveUrl(this.address, this.#operator));
    const waiting: LiveMessage[] = [];
    let wake = () => {};
    let over = false;
    let opened = false;
    socket.onopen = () => {
      opened = true;
      socket.send(JSON.stringify(NO_PICTURES));
    };
    socket.onmessage = ({ data }: MessageEvent<unknown>) => {
      if (typeof data !== "string") return;
      waiting.push(JSON.parse(data) as LiveMessage);
      wake();
    };
    socket.onclose = () => {
      over = true;
      wake();
    };
    try {
      while (true) {
        const message = waiting.shift();
        if (message) yield message;
        else if (over) break;
        else
          await new Promise<void>((resolve) => {
            wake = resolve;
          });
      }
    } finally {
      socket.close();
    }
    if (!opened) throw new Unreachable(`${this.address} does not answer`);
  }
}
