/** The cards of the tab of tours, loaded together. */

export { Tours } from "./TourPanel";
export { TourReports } from "./TourReports";
export { TourRun } from "./TourRunPanel";
