/** One script for what the operator page needs at once: what parts share that are loaded later is not cut off from it. */

import type { Rolldown } from "vite";

const PAGE = "/src/main.tsx";
/** Pages of their own; what they share with the operator page stays in scripts that are small. */
const OTHERS = ["/src/visitor/main.tsx", "/src/face/main.ts", "/src/rest/main.ts"];

/** The name of the script that the module `id` goes into; null: as the bundler sees fit. */
export function scriptOf(id: string, context: Rolldown.ChunkingContext): string | null {
  const importers = new Set([id]);
  for (const each of importers) for (const by of context.getModuleInfo(each)?.importers ?? []) importers.add(by);
  const of = (page: string) => [...importers].some((each) => each.endsWith(page));
  if (!of(PAGE)) return null;
  if (!OTHERS.some(of)) return "page";
  return id.includes("/src/protocol/") ? "protocol" : null;
}
