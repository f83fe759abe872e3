/** Requests to REST under `api/v1`: JSON in and out, errors as problem details (RFC 9457). */

import { t } from "../i18n";
import { Problem, readProblem } from "./problem";
import { upload } from "./upload";

const ROOT = "./api/v1";
const JSON_TYPE = "application/json";

/** Of what is linked to, rather than asked for. */
export function address(path: string): string {
  return ROOT + path;
}

/** Of a path of files. */
export function parts(file: string): string {
  return file.split("/").map(encodeURIComponent).join("/");
}

/** A fresh key for one intended change; `randomUUID` exists only in secure contexts. */
export function idempotencyKey(): string {
  if (typeof crypto.randomUUID === "function") return crypto.randomUUID();
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

export class Requests {
  constructor(private readonly operator: () => string) {}

  /** The JSON of the answer; null where it has none. */
  async ask(method: string, path: string, body?: unknown, more: Record<string, string> = {}): Promise<unknown> {
    const response = await this.answer(method, path, body, more);
    return response.status === 204 ? null : await response.json().catch(() => null);
  }

  /** A file is sent as it is, all else as JSON. Rejects with a Problem. */
  async answer(method: string, path: string, body: unknown, more: Record<string, string>): Promise<Response> {
    const headers: Record<string, string> = {
      ...this.headers(),
      ...(body === undefined ? {} : { "Content-Type": JSON_TYPE }),
      ...more,
    };
    let response: Response;
    try {
      response = await fetch(ROOT + path, {
        method,
        headers,
        credentials: "same-origin",
        ...(body === undefined ? {} : { body: body instanceof Blob ? body : JSON.stringify(body) }),
      });
    } catch {
      throw new Problem(
        0,
        t("No answer"),
        t("The robot did not answer. Check that its program runs and that you are on its network."),
      );
    }
    if (!response.ok) throw await readProblem(response);
    return response;
  }

  upload(path: string, file: Blob, onShare: (share: number) => void, signal: AbortSignal): Promise<unknown> {
    return upload(ROOT + path, file, this.headers(), onShare, signal);
  }

  private headers(): Record<string, string> {
    return { Accept: JSON_TYPE, "X-HBBA-Operator": headerSafe(this.operator()) };
  }
}

/** Header values are Latin-1; a name in another script is sent percent-encoded. */
function headerSafe(name: string): string {
  return /^[\x20-\x7e]*$/.test(name) ? name : encodeURIComponent(name);
}
