/** From where the 3D view may look, each with its key; the poses are the console's (`app/console/view/viewpoints.py`). */

export const VIEWPOINTS = [
  { name: "behind", code: "Digit1", words: "Behind the robot" },
  { name: "aligned", code: "Digit2", words: "Over its shoulder, along robot and head" },
  { name: "free", code: "Digit3", words: "Free: turns with neither robot nor head" },
  { name: "head", code: "Digit4", words: "Along the head, not the base" },
  { name: "first_person", code: "Digit5", words: "Through its camera" },
  { name: "top", code: "Digit6", words: "From the top" },
  { name: "map", code: "Digit7", words: "The whole map" },
] as const;

export type Viewpoint = (typeof VIEWPOINTS)[number]["name"];

export const VIEW_KEYS: ReadonlySet<string> = new Set(VIEWPOINTS.map(({ code }) => code));

/** The viewpoint of a key, held with no other; null: none. */
export function viewpointOf(event: Pick<KeyboardEvent, "code" | "ctrlKey" | "altKey" | "metaKey">): Viewpoint | null {
  if (event.ctrlKey || event.altKey || event.metaKey) return null;
  return VIEWPOINTS.find(({ code }) => code === event.code)?.name ?? null;
}
