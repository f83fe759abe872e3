/** REST for visitors' phones: admission by the key of a link, presses, what is shown. */

import { address, parts, type Requests } from "./requests";
import type { VisitorKey, VisitorPress } from "./types";

export class VisitorRest {
  constructor(private readonly requests: Requests) {}

  /** Resolves where this browser may see the tour as a visitor. */
  async checkVisitor(): Promise<void> {
    await this.requests.ask("GET", "/visitor/session");
  }

  async enterAsVisitor(key: string): Promise<void> {
    await this.requests.ask("POST", "/visitor/session", { key } satisfies VisitorKey);
  }

  async pressAsVisitor(press: VisitorPress): Promise<void> {
    await this.requests.ask("POST", "/visitor/press", press);
  }

  /** What visitors are shown; `file` as the tour names it. */
  visitorMedia(file: string): string {
    return address(`/visitor/media/${parts(file)}`);
  }
}
