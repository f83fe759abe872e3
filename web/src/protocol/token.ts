/** The token that `hbba run` prints behind the # of its address, or null; null too where there is none to read. */
export function tokenIn(hash: string): string | null {
  return new URLSearchParams(hash.replace(/^#/, "")).get("token") || null;
}

/** The key of a link for visitors, or null. */
export function keyIn(hash: string): string | null {
  return new URLSearchParams(hash.replace(/^#/, "")).get("key") || null;
}
