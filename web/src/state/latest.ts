/** The newest message of each type that the robot sent. */

import { type ReadonlySignal, type Signal, signal } from "@preact/signals";
import type { FromRobot } from "../protocol/types";

export type MessageType = FromRobot["type"];
type Of<M, T> = M extends { type: unknown } ? (T extends M["type"] ? M : never) : never;
/** The message of type `T`. */
export type Message<T extends MessageType> = Of<FromRobot, T>;

export class Latest {
  private readonly signals = new Map<MessageType, Signal<FromRobot | null>>();
  private readonly outdated = new Set<MessageType>();

  /** Null: none has come, or the last is void. */
  of<T extends MessageType>(type: T): ReadonlySignal<Message<T> | null> {
    return this.signal(type) as unknown as ReadonlySignal<Message<T> | null>;
  }

  put(message: FromRobot): void {
    this.outdated.delete(message.type);
    this.signal(message.type).value = message;
  }

  /** What is kept is of another connection or another time. It stays until `dropOutdated`, so that nothing flickers. */
  outdate(): void {
    for (const type of this.signals.keys()) this.outdated.add(type);
  }

  /** Drops what has not come again since `outdate`. */
  dropOutdated(): void {
    for (const type of this.outdated) this.signal(type).value = null;
    this.outdated.clear();
  }

  private signal(type: MessageType): Signal<FromRobot | null> {
    let found = this.signals.get(type);
    if (!found) {
      found = signal<FromRobot | null>(null);
      this.signals.set(type, found);
    }
    return found;
  }
}
