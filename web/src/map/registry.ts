/** What is drawn of percepts and places on the map, lowest first: one line for each type of message. */

import { landmarksLayer } from "./landmarksLayer";
import type { Layer } from "./layer";
import { peopleLayer } from "./peopleLayer";
import { personsLayer } from "./personsLayer";
import { placesLayer } from "./placesLayer";

export const LAYERS: readonly Layer[] = [landmarksLayer, placesLayer, peopleLayer, personsLayer];
