/** One operation as a request, and its answer. */

const BASE = "/api/v1";

/** `path` below `/api/v1`; members of `query` and `headers` that are undefined or null are left out. */
export interface Request {
  method: string;
  path: string;
  answer: "nothing" | "json" | "text" | "bytes";
  body?: unknown;
  media?: string;
  query?: Record<string, unknown>;
  headers?: Record<string, string | null | undefined>;
}

/** A refusal, as the program words it (RFC 9457). `kind`: the last part of its type, such as `no-such-desire`. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    readonly kind: string,
    readonly detail: string,
    readonly errors: readonly { field: string; message: string }[],
  ) {
    super(`${detail} (${kind}, ${status})`);
    this.name = "Problem";
  }
}

/** The console does not answer: it does not run, or not there. */
export class Unreachable extends Error {
  override name = "Unreachable";
}

export function urlOf(address: string, { path, query }: Request): string {
  const given = Object.entries(query ?? {}).filter(([, value]) => value !== undefined && value !== null);
  const asked = new URLSearchParams(given.map(([name, value]) => [name, String(value)]));
  return `${address}${BASE}${path}${given.length > 0 ? `?${asked}` : ""}`;
}

export function liveUrl(address: string, operator: string | undefined): string {
  const asked = operator ? `?operator=${encodeURIComponent(operator)}` : "";
  return `${address.replace(/^http/, "ws")}${BASE}/live${asked}`;
}

/** What `fetch` is given for `request`, beside `headers` that say who asks. */
export function initOf(request: Request, headers: Record<string, string>): RequestInit {
  const all: Record<string, string> = { ...headers };
  for (const [name, value] of Object.entries(request.headers ?? {})) if (value != null) all[name] = value;
  if (request.body === undefined) return { method: request.method, headers: all };
  all["content-type"] = request.media ?? "application/json";
  const asItIs = typeof request.body === "string" || request.body instanceof ArrayBuffer;
  const body = asItIs ? (request.body as string | ArrayBuffer) : JSON.stringify(request.body);
  return { method: request.method, headers: all, body };
}

/** What `response` says. Throws Problem for a refusal. */
export async function answerOf(request: Request, response: Response): Promise<unknown> {
  if (!response.ok) throw problemOf(response.status, await response.text());
  if (request.answer === "nothing" || response.status === 204) return undefined;
  if (request.answer === "json") return response.json();
  return request.answer === "text" ? response.text() : response.arrayBuffer();
}

/** The refusal in an answer; what is no problem document (a proxy's page) is named by its status. */
export function problemOf(status: number, text: string): Problem {
  let document: Record<string, unknown> = {};
  try {
    const read: unknown = JSON.parse(text);
    if (read !== null && typeof read === "object" && !Array.isArray(read)) document = read as Record<string, unknown>;
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
  }
  const kind = String(document.type ?? "").split(":").pop() || "unknown";
  const detail = String(document.detail ?? document.title ?? `the answer has status ${status}`);
  const errors = Array.isArray(document.errors) ? (document.errors as { field: string; message: string }[]) : [];
  return new Problem(status, kind, detail, errors);
}
