/** The side column's panels: one line each, in the order of their tabs. */

import { aroundPanel } from "../around/AroundPanel";
import { addDesirePanel, desiresPanel } from "../desires/DesiresPanel";
import { rulesPanel } from "../desires/RulesPanel";
import { lanesPanel } from "../lanes/Lanes";
import { mapPanel } from "../map/MapPanel";
import { wordsPanel } from "../speech/WordsPanel";
import { troubled } from "../state/load";
import { badgeOf, isUrgent } from "../tours/tourRunText";
import { later } from "../ui/later";
import { eventsPanel } from "./Events";
import { foundPanel } from "./Found";
import { intentionPanel } from "./Intention";
import { peoplePanel } from "./People";
import { type Panel, panel } from "./panel";
import { whatIfPanel } from "./WhatIf";

// What most visitors never open is loaded with the tab that shows it.
const graphPanel = panel({
  type: "load",
  tab: "Graph",
  Card: later(async () => (await import("../graph/GraphPanel")).GraphCard),
  offered: (_, phone) => !phone,
});
const placesPanel = panel({
  type: "places",
  tab: "Map",
  Card: later(async () => (await import("../map/cards")).Places),
});
const zonesPanel = panel({
  type: "zones",
  tab: "Map",
  Card: later(async () => (await import("../map/cards")).Zones),
  offered: ({ store }) => store.body.value.maps,
});
const mapsPanel = panel({
  type: "localization",
  tab: "Map",
  Card: later(async () => (await import("../map/cards")).Maps),
  offered: ({ store }) => store.body.value.maps && !store.replay.value,
});
const tourRunPanel = panel({
  type: "tour",
  tab: "Tour",
  Card: later(async () => (await import("../tours/cards")).TourRun),
  offered: ({ store }) => store.body.value.maps && store.of("tour").value !== null,
  badge: badgeOf,
  alarm: isUrgent,
});
const tourPanel = panel({
  type: "places",
  tab: "Tour",
  Card: later(async () => (await import("../tours/cards")).Tours),
  offered: ({ store }) => store.body.value.maps && !store.replay.value,
});
const tourReportsPanel = panel({
  type: "tour",
  tab: "Tour",
  Card: later(async () => (await import("../tours/cards")).TourReports),
  offered: ({ store, tours }) => store.of("tour").value !== null && !store.replay.value && tours.draft.value === null,
});
const memoryPanel = panel({
  type: "memory",
  tab: "Memory",
  Card: later(async () => (await import("../memory/MemoryPanel")).Memory),
  offered: ({ store }) => store.of("memory").value?.on === true,
});
const loadPanel = panel({
  type: "load",
  tab: "Load",
  Card: later(async () => (await import("./loadCards")).Load),
  offered: () => true,
  badge: (message) => (troubled(message) ? "!" : 0),
  alarm: troubled,
});
const picturesPanel = panel({
  type: "load",
  tab: "Load",
  Card: later(async () => (await import("./loadCards")).Pictures),
  offered: ({ store }) => store.hello.value?.channels.camera !== false,
});
const linkPanel = panel({
  type: "link",
  tab: "Load",
  Card: later(async () => (await import("./loadCards")).LinkShape),
});
const recordingsPanel = panel({
  type: "recorder",
  tab: "Recordings",
  Card: later(async () => (await import("../recordings/Recordings")).Recordings),
  offered: ({ store }) => !store.replay.value,
  alarm: (message) => message?.state === "stopped",
});

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
