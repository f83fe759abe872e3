/** All directions around the robot on a flat strip: straight ahead in the middle, behind at both ends. Pure. */

/** px; three times as wide as high, it reaches 60° up and down. */
export interface Strip {
  width: number;
  height: number;
}

export interface Point {
  x: number;
  y: number;
}

export const SHAPE = 3;

/** Into −π…π. */
export function wrapped(angle: number): number {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

/** px of one radian, along and across. */
export function scale(strip: Strip): number {
  return strip.width / (2 * Math.PI);
}

/** Where a direction is; what is higher or lower than the strip reaches is at its edge. */
export function place(strip: Strip, azimuth: number, elevation: number): Point {
  const y = strip.height / 2 - elevation * scale(strip);
  return { x: strip.width / 2 - wrapped(azimuth) * scale(strip), y: Math.max(0, Math.min(strip.height, y)) };
}

/** Which direction is at a point. */
export function direction(strip: Strip, { x, y }: Point): { azimuth: number; elevation: number } {
  return { azimuth: (strip.width / 2 - x) / scale(strip), elevation: (strip.height / 2 - y) / scale(strip) };
}

/** Where the panorama goes, whose `width` px are the half circle ahead: the middle half, level in the middle. */
export function pictureBox(strip: Strip, width: number, height: number): Point & Strip {
  const w = Math.PI * scale(strip);
  const h = (w * height) / width;
  return { x: (strip.width - w) / 2, y: (strip.height - h) / 2, width: w, height: h };
}
