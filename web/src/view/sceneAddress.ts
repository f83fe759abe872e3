/** Where the 3D view's frame is taken from. */

import type { Rest } from "../protocol/rest";

/** A port that a firewall is silent about counts as out of reach after this time. */
const PROBE_MS = 3000;

/**
 * The view's address on its own port, if that answers to this page; else `own`. Without a secure context (plain http
 * from another computer) browsers give a frame of the same host no process of its own, and the port is no use.
 */
export async function sceneAddress(rest: Pick<Rest, "scene">, own: string, secure: boolean): Promise<string> {
  if (!secure) return own;
  try {
    const { url } = await rest.scene();
    if (url === null) return own;
    const answer = await fetch(new URL("health", url), {
      signal: AbortSignal.timeout(PROBE_MS),
      credentials: "omit",
      cache: "no-store",
    });
    return answer.ok ? url : own;
  } catch {
    return own; // whatever the reason: it is not reached from here
  }
}
