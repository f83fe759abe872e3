/** The page in French. Each text is in one file, by where it is used first. */

import { desires } from "./desires";
import { drive } from "./drive";
import { lanes } from "./lanes";
import { map } from "./map";
import { memory } from "./memory";
import { page } from "./page";
import { panels } from "./panels";
import { recordings } from "./recordings";
import robot from "./robot.json";
import { sound } from "./sound";
import { tours } from "./tours";
import { view } from "./view";

export { robot };

export const fr = {
  ...desires,
  ...drive,
  ...lanes,
  ...map,
  ...memory,
  ...page,
  ...panels,
  ...recordings,
  ...sound,
  ...tours,
  ...view,
} as const;
