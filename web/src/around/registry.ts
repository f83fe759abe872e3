/** What is drawn around the robot, lowest first: one line for each type of message. */

import type { Layer } from "./layer";
import { perceivedLayer } from "./PerceivedLayer";
import { heatLayer, salientLayer } from "./SaliencyLayer";

export const LAYERS: readonly Layer[] = [heatLayer, perceivedLayer, salientLayer];
