/** The cards below the map in its tab, loaded together. */

export { Maps } from "./Maps";
export { Places } from "./Places";
export { Zones } from "./Zones";
