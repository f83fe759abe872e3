/** A visitor's phone: gets in with the key of its link, shows what comes, presses. */

import { batch, signal } from "@preact/signals";
import type { LiveConnection } from "../protocol/live";
import { Problem } from "../protocol/problem";
import type { FromRobot, VisitorPress, VisitorView } from "../protocol/types";
import type { VisitorRest } from "../protocol/visitorRest";

/** `over`: the link is of a run that has ended; nothing is tried any more. */
export type Phase = "connecting" | "live" | "lost" | "over";
export type Refusal = "" | "notNow" | "tooOften";

const AGAIN_MS = 4000;
/** After a press, so that a second tap is no second press. */
const REST_MS = 700;
const SAID_MS = 4000;
const KEY = "hbba.visitor.language";

export interface Connection {
  open(): void;
  close(): void;
}

export class VisitorControl {
  readonly view = signal<VisitorView | null>(null);
  readonly phase = signal<Phase>("connecting");
  /** Chosen on this phone; null: never. */
  readonly language = signal<string | null>(remembered());
  readonly refusal = signal<Refusal>("");
  readonly busy = signal(false);
  private readonly live: Connection;

  constructor(
    private readonly rest: VisitorRest,
    /** Of the link; null: it had none. */
    private readonly key: string | null,
    connect: (handlers: ConstructorParameters<typeof LiveConnection>[1]) => Connection,
  ) {
    this.live = connect({
      opened: () => (this.phase.value = "live"),
      message: (message) => this.take(message),
      binary: () => undefined,
      roundTrip: () => undefined,
      lost: (everOpened) => {
        this.phase.value = "lost";
        // The end of a run ends the connection, too: ask which it is, rather than opening again and again.
        setTimeout(
          () => {
            this.live.close();
            void this.enter();
          },
          everOpened ? 0 : AGAIN_MS,
        );
        queueMicrotask(() => this.live.close());
      },
    });
  }

  /** Resolves once it is known whether this phone may. */
  async enter(): Promise<void> {
    try {
      await this.admitted();
      this.live.open();
    } catch (error) {
      const refused = error instanceof Problem && error.status === 401;
      batch(() => {
        this.phase.value = refused ? "over" : "lost";
        if (refused) this.view.value = null;
      });
      if (!refused) setTimeout(() => void this.enter(), AGAIN_MS);
    }
  }

  choose(language: string): void {
    this.language.value = language;
    localStorage.setItem(KEY, language);
  }

  async press(what: VisitorPress): Promise<void> {
    if (this.busy.peek()) return;
    this.busy.value = true;
    try {
      await this.rest.pressAsVisitor(what);
      this.refusal.value = "";
    } catch (error) {
      const often = error instanceof Problem && error.status === 429;
      this.refusal.value = often ? "tooOften" : "notNow";
      setTimeout(() => (this.refusal.value = ""), SAID_MS);
    }
    setTimeout(() => (this.busy.value = false), REST_MS);
  }

  mediaAddress(file: string): string {
    return this.rest.visitorMedia(file);
  }

  /** A session from before goes on; a key begins one. */
  private async admitted(): Promise<void> {
    try {
      await this.rest.checkVisitor();
    } catch (error) {
      const asks = error instanceof Problem && error.status === 401;
      if (!asks || this.key === null) throw error;
      await this.rest.enterAsVisitor(this.key);
    }
  }

  private take(message: FromRobot): void {
    if (message.type === "visitor") this.view.value = message;
  }
}

function remembered(): string | null {
  return typeof localStorage === "undefined" ? null : localStorage.getItem(KEY);
}
