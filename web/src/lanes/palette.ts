/** Colours of the lanes, on the page and on paper. Each series is at least 3:1 against what it is drawn on and crosses. */

export interface Palette {
  ground: string;
  /** Desired utility's dashes, the intensity's line, 1/φ as an area with its edge, and the measured rate over it. */
  utility: string;
  /** Its figures. */
  utilityWords: string;
  intensity: string;
  rate: string;
  edge: string;
  measured: string;
  scale: string;
  foot: string;
  words: string;
  mark: string;
  /** States along the foot. */
  intended: string;
  unfulfilled: string;
  inhibited: string;
  needed: string;
}

export const SCREEN: Palette = {
  ground: "#11161e",
  utility: "#ea4a4f",
  utilityWords: "#ff8f8f",
  intensity: "#ffffff",
  rate: "#14305c",
  edge: "#5b9bff",
  measured: "#a9d6ff",
  scale: "#232c39",
  foot: "#313c4b",
  words: "#a3b1c2",
  mark: "#e5c07b",
  intended: "#52d18c",
  unfulfilled: "#ff7b7b",
  inhibited: "#c3aef0",
  needed: "#8fa3ba",
};

export const PAPER: Palette = {
  ground: "#ffffff",
  utility: "#d6303a",
  utilityWords: "#b3202b",
  intensity: "#000000",
  rate: "#dbe7fb",
  edge: "#2f62b3",
  measured: "#1d4a94",
  scale: "#e3e7ec",
  foot: "#b4bcc6",
  words: "#333c47",
  mark: "#8a5a00",
  intended: "#13713f",
  unfulfilled: "#c01c28",
  inhibited: "#6b3fc0",
  needed: "#5a6878",
};

/** On the screen in light colours: as on paper, on the ground of a panel. */
export const LIGHT: Palette = { ...PAPER, ground: "#fbfcfe" };

/** The same for style sheets: `--lane-utility`. */
export function variables(palette: Palette): Record<string, string> {
  return Object.fromEntries(Object.entries(palette).map(([name, color]) => [`--lane-${name}`, color]));
}

/** Contrast of two colours, 1 to 21 (WCAG 2.2). */
export function contrast(one: string, other: string): number {
  const [a, b] = [luminance(one), luminance(other)];
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}

function luminance(color: string): number {
  const [r, g, b] = [1, 3, 5].map((at) => {
    const share = Number.parseInt(color.slice(at, at + 2), 16) / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
}
