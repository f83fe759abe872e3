/** Figures about load that the robot does not send. */

import type { Intention, Load } from "../protocol/types";

/** CPU of the modules whose filters attention sets: what its budget is about. */
export function attendedCpu(load: Load, intention: Intention | null): number {
  const governed = new Set(Object.keys(intention?.filters ?? {}).map((port) => port.split(".")[0]));
  return load.modules.reduce((sum, module) => sum + (governed.has(module.name) ? module.cpu : 0), 0);
}

export function troubled(load: Load | null): boolean {
  return load?.modules.some(({ state }) => state === "failed" || state === "hung") ?? false;
}
