/** How the page is divided: which parts are shown, where and how large. Pure. */

export const PRESETS = ["drive", "tour", "attention", "debug"] as const;
export type Preset = (typeof PRESETS)[number];

export interface Layout {
  /** Shares of the window: the side column's of its width, the lanes' of its height. */
  side: number;
  lanes: number;
  sideShown: boolean;
  lanesShown: boolean;
  /** The side column's edge. */
  edge: "left" | "right";
  lanesAt: "bottom" | "top";
}

/** Within these shares every part stays usable. */
export const SIDE_SHARES = { least: 0.18, most: 0.6 } as const;
export const LANES_SHARES = { least: 0.16, most: 0.75 } as const;

const COMMON = { sideShown: true, lanesShown: true, edge: "right", lanesAt: "bottom" } as const;

/** Each preset as it comes. */
export const DEFAULTS: Readonly<Record<Preset, Readonly<Layout>>> = {
  drive: { ...COMMON, side: 0.24, lanes: 0.25, lanesShown: false },
  tour: { ...COMMON, side: 0.34, lanes: 0.25, lanesShown: false },
  attention: { ...COMMON, side: 0.28, lanes: 0.33 },
  debug: { ...COMMON, side: 0.36, lanes: 0.4 },
};

/** The tab of the side column that a preset opens. */
export const TABS: Readonly<Record<Preset, string>> = {
  drive: "map",
  tour: "tour",
  attention: "attention",
  debug: "load",
};

export interface Chosen {
  preset: Preset;
  layout: Layout;
}

export const FIRST: Chosen = { preset: "attention", layout: DEFAULTS.attention };

/** `layout` with shares that leave each part usable. */
export function limited(layout: Layout): Layout {
  return { ...layout, side: within(layout.side, SIDE_SHARES), lanes: within(layout.lanes, LANES_SHARES) };
}

/** As a link says it: `attention-28-33-sl-r` (shares in %, parts shown: s, l, or x for none; edge, and t with the lanes
 * on top). */
export function encode({ preset, layout }: Chosen): string {
  const parts = `${layout.sideShown ? "s" : ""}${layout.lanesShown ? "l" : ""}` || "x";
  const edges = `${layout.edge[0]}${layout.lanesAt === "top" ? "t" : ""}`;
  return [preset, percent(layout.side), percent(layout.lanes), parts, edges].join("-");
}

/** What a link says; null: nothing that this page understands. */
export function decode(text: string | null): Chosen | null {
  const found = /^([a-z]+)-(\d{1,2})-(\d{1,2})-(sl|s|l|x)-([lr])(t?)$/.exec(text ?? "");
  if (!found) return null;
  const [, name, side, lanes, parts, edge, top] = found;
  const preset = PRESETS.find((each) => each === name);
  if (!preset) return null;
  return {
    preset,
    layout: limited({
      side: Number(side) / 100,
      lanes: Number(lanes) / 100,
      sideShown: parts!.includes("s"),
      lanesShown: parts!.includes("l"),
      edge: edge === "l" ? "left" : "right",
      lanesAt: top ? "top" : "bottom",
    }),
  };
}

function percent(share: number): number {
  return Math.round(100 * share);
}

function within(share: number, { least, most }: { least: number; most: number }): number {
  return Math.min(most, Math.max(least, share));
}
