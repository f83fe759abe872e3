/** What a layer of the map is: the marks of one type of message. */

import type { Message, MessageType } from "../state/latest";
import type { Context } from "./canvas";
import type { Point } from "./mapProjection";

export interface LayerOf<T extends MessageType> {
  type: T;
  /**
   * `onScreen`: a place in `odom` (m), or on the map where its `frame` says so, in px; null while it is not known where
   * `odom` is on the map.
   */
  draw: (context: Context, message: Message<T>, onScreen: (place: Point & { frame?: string }) => Point | null) => void;
}

export type Layer = LayerOf<MessageType>;

/** Forgets which type the layer is of: the registry holds layers of all. */
export function layer<T extends MessageType>(made: LayerOf<T>): Layer {
  return made as unknown as Layer;
}
