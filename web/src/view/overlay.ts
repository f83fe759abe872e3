/** What an overlay of the camera's picture is: the frames of one type of message. */

import type { ComponentType } from "preact";
import type { Message, MessageType } from "../state/latest";

export interface OverlayOf<T extends MessageType> {
  type: T;
  Frames: ComponentType<{ message: Message<T> | null }>;
}

export type Overlay = OverlayOf<MessageType>;

/** Forgets which type the overlay is of: the registry holds overlays of all. */
export function overlay<T extends MessageType>(made: OverlayOf<T>): Overlay {
  return made as unknown as Overlay;
}
