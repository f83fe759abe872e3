/** What a layer of the strip of all directions is: the marks of one type of message. */

import type { ComponentType } from "preact";
import type { Message, MessageType } from "../state/latest";
import type { Point, Strip } from "./stripProjection";

export interface Box extends Strip, Point {}

/** Text over `bottom`, centred on `x`; px. */
export interface Name {
  text: string;
  /** Instead, where there is no room for that. */
  short?: string;
  x: number;
  bottom: number;
  color: string;
  opacity: number;
}

export interface Pen {
  context: CanvasRenderingContext2D;
  strip: Strip;
  large: boolean;
  /** Whether there is room for the names of small marks. */
  named: boolean;
  /** Names are not written over `box`. */
  keepOff: (box: Box) => void;
  /** Written when all marks are drawn. */
  name: (name: Name) => void;
  /** Drawn last of all. */
  over: (drawn: () => void) => void;
}

export interface LayerOf<T extends MessageType> {
  type: T;
  /** Layers that are shown and hidden together by a button; none: always shown. */
  group?: "salient";
  /** All of it in words: "1 person ahead, 1 voice at 30° left"; empty: nothing to be seen. `now`: robot's clock, s. */
  words: (message: Message<T> | null, now: number) => string;
  /** Returns whether something fades, so that it has to be drawn again soon. */
  draw: (pen: Pen, message: Message<T> | null, now: number) => boolean;
  /** List items of the same marks, for screen readers. */
  Marks: ComponentType<{ message: Message<T> | null; now: number }>;
  /** Words on what is at a point of the strip; empty: nothing. */
  hover?: (strip: Strip, at: Point, message: Message<T> | null, now: number) => string;
}

export type Layer = LayerOf<MessageType>;

/** Forgets which type the layer is of: the registry holds layers of all. */
export function layer<T extends MessageType>(made: LayerOf<T>): Layer {
  return made as unknown as Layer;
}
