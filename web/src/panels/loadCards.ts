/** The cards of the tab of load, loaded together. */

export { LinkShape } from "./LinkShape";
export { Load } from "./Load";
export { Pictures } from "./Pictures";
