/** The side column's panels: one line each, in the order of their tabs. */

import { aroundPanel } from "../around/AroundPanel";
import { addDesirePanel, desiresPanel } from "../desires/DesiresPanel";
import { rulesPanel } from "../desires/RulesPanel";
import { graphPanel } from "../graph/GraphPanel";
import { lanesPanel } from "../lanes/Lanes";
import { mapPanel } from "../map/MapPanel";
import { mapsPanel } from "../map/Maps";
import { placesPanel } from "../map/Places";
import { zonesPanel } from "../map/Zones";
import { memoryPanel } from "../memory/MemoryPanel";
import { recordingsPanel } from "../recordings/Recordings";
import { wordsPanel } from "../speech/WordsPanel";
import { tourPanel } from "../tours/TourPanel";
import { tourReportsPanel, tourRunPanel } from "../tours/TourRunPanel";
import { eventsPanel } from "./Events";
import { foundPanel } from "./Found";
import { intentionPanel } from "./Intention";
import { linkPanel } from "./LinkShape";
import { loadPanel } from "./Load";
import { peoplePanel } from "./People";
import { picturesPanel } from "./Pictures";
import type { Panel } from "./panel";
import { whatIfPanel } from "./WhatIf";

export const PANELS: readonly Panel[] = [
  addDesirePanel,
  intentionPanel,
  whatIfPanel,
  desiresPanel,
  rulesPanel,
  mapPanel,
  placesPanel,
  zonesPanel,
  mapsPanel,
  tourRunPanel,
  tourPanel,
  tourReportsPanel,
  lanesPanel,
  aroundPanel,
  peoplePanel,
  wordsPanel,
  memoryPanel,
  foundPanel,
  loadPanel,
  graphPanel,
  picturesPanel,
  linkPanel,
  eventsPanel,
  recordingsPanel,
];
