/**
 * The emergency stop's own path: a worker with a connection of its own, beside the page's. What the page's thread does
 * after the press, and what waits in the page's own connection, holds it up no more. It asks until the robot has answered.
 */

/** The press: `url` of the stop, and the operator's name for it. */
export interface StopOrder {
  url: string;
  operator: string;
}

const ANSWER_WITHIN_MS = 1500;
const AGAIN_MS = 200;
/** A robot that was out of reach for so long has stopped what a hand drove; what it does then, people look at first. */
export const GIVE_UP_MS = 10_000;

/** Asks for the stop until it is answered; whether it is latched. `post` sends one request: its status, or it throws. */
export async function orderStop(post: () => Promise<number>, now: () => number, wait: (ms: number) => Promise<void>) {
  const end = now() + GIVE_UP_MS;
  for (;;) {
    const status = await post().catch(() => 0);
    // 504: the guard has not confirmed it yet. What else is refused stays refused.
    if (status >= 200 && status < 500 && status !== 429) return status < 300;
    if (now() > end) return false;
    await wait(AGAIN_MS);
  }
}

function post({ url, operator }: StopOrder): Promise<number> {
  return fetch(url, {
    method: "POST",
    credentials: "same-origin",
    headers: { "X-HBBA-Operator": encodeURIComponent(operator) },
    signal: AbortSignal.timeout(ANSWER_WITHIN_MS),
  }).then((response) => response.status);
}

if (typeof document === "undefined" && typeof self !== "undefined" && "onmessage" in self) {
  self.onmessage = ({ data }: MessageEvent<StopOrder>) =>
    void orderStop(
      () => post(data),
      () => performance.now(),
      (ms) => new Promise((done) => setTimeout(done, ms)),
    );
}
