/** What is drawn over the camera's picture: one line for each type of message. */

import { FaceFrames } from "./FaceFrames";
import { type Overlay, overlay } from "./overlay";

export const OVERLAYS: readonly Overlay[] = [overlay({ type: "perceived", Frames: FaceFrames })];
