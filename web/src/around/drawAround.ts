/** Draws the strip of all directions: the picture ahead, a grid where there is none, and what was perceived. */

import type { FaceMark, SoundKind, SoundMark } from "./perceptMarks";
import { type Point, pictureBox, place, type Strip, scale } from "./stripProjection";

export interface Shown {
  /** Null: there is none. */
  picture: HTMLCanvasElement | null;
  old: boolean;
  faces: FaceMark[];
  sounds: SoundMark[];
  /** What is left of a noise's flash, 0 to 1. */
  flash: number;
  /** Names of sounds, and degrees along the edge. */
  large: boolean;
}

/** As in the 3D view. */
const SOUND: Record<SoundKind, string> = { voice: "235 45 40", sound: "240 150 40", unjudged: "150 156 168" };
const FACE = "rgb(70 225 140)";
const FLASH = "255 214 90";
const FOOT = 17;
/** From over a mark to under it, px at the least. */
const BELOW = 16;
/** px; on less, figures would run into the words. */
const NUMBERED = 640;
const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif";
const WORDS = [
  { degrees: 180, text: "behind", align: "left" },
  { degrees: 90, text: "left", align: "center" },
  { degrees: 0, text: "ahead", align: "center" },
  { degrees: -90, text: "right", align: "center" },
  { degrees: -180, text: "behind", align: "right" },
] as const;

type Context = CanvasRenderingContext2D;
interface Box extends Strip, Point {}

export function draw(context: Context, strip: Strip, shown: Shown): void {
  context.fillStyle = "#0b0f15";
  context.fillRect(0, 0, strip.width, strip.height);
  drawGrid(context, strip);
  if (shown.picture) drawPicture(context, strip, shown.picture, shown.old);
  drawFoot(context, strip, shown.large);
  // Names keep off what they name.
  const taken = [
    ...shown.faces.map((face) => frameOf(strip, face)),
    ...shown.sounds.map((sound) => boxOf(strip, sound, shown.large)),
  ];
  for (const sound of shown.sounds) drawSound(context, strip, sound, shown.large);
  for (const face of shown.faces) drawFrame(context, strip, face);
  for (const face of [...shown.faces].reverse()) drawFaceName(context, strip, face, taken);
  if (shown.large && strip.width >= NUMBERED)
    for (const sound of shown.sounds) drawSoundName(context, strip, sound, taken);
  if (shown.flash > 0) drawFlash(context, strip, shown.flash);
}

function drawGrid(context: Context, strip: Strip): void {
  const line = (from: Point, to: Point, color: string) => {
    context.strokeStyle = color;
    context.beginPath();
    context.moveTo(Math.round(from.x) + 0.5, Math.round(from.y) + 0.5);
    context.lineTo(Math.round(to.x) + 0.5, Math.round(to.y) + 0.5);
    context.stroke();
  };
  context.lineWidth = 1;
  for (let degrees = -150; degrees <= 150; degrees += 30) {
    const { x } = place(strip, radians(degrees), 0);
    line({ x, y: 0 }, { x, y: strip.height }, degrees % 90 === 0 ? "#2f3a49" : "#1b232e");
  }
  for (const degrees of [-30, 0, 30]) {
    const { y } = place(strip, 0, radians(degrees));
    line({ x: 0, y }, { x: strip.width, y }, degrees === 0 ? "#2f3a49" : "#1b232e");
  }
}

function drawPicture(context: Context, strip: Strip, picture: HTMLCanvasElement, old: boolean): void {
  const box = pictureBox(strip, picture.width, picture.height);
  context.save();
  if (old) {
    context.globalAlpha = 0.45;
    context.filter = "grayscale(0.8)";
  }
  context.drawImage(picture, box.x, box.y, box.width, box.height);
  context.restore();
}

function drawFoot(context: Context, strip: Strip, large: boolean): void {
  const top = strip.height - FOOT;
  context.fillStyle = "rgb(10 13 18 / 0.78)";
  context.fillRect(0, top, strip.width, FOOT);
  context.font = `11.5px ${FONT}`;
  context.textBaseline = "middle";
  context.fillStyle = "#c3cedb";
  context.strokeStyle = "#5b6a7d";
  context.lineWidth = 1;
  for (let degrees = -150; degrees <= 150; degrees += 30) {
    const x = Math.round(place(strip, radians(degrees), 0).x) + 0.5;
    if (degrees % 90 === 0) continue;
    context.beginPath();
    context.moveTo(x, top);
    context.lineTo(x, top + 4);
    context.stroke();
    if (!large || strip.width < NUMBERED) continue;
    context.textAlign = "center";
    context.fillText(`${Math.abs(degrees)}°`, x, top + 10);
  }
  for (const { degrees, text, align } of WORDS) {
    context.textAlign = align;
    const x = strip.width / 2 - radians(degrees) * scale(strip);
    context.fillText(text, x + (align === "left" ? 5 : align === "right" ? -5 : 0), top + 9);
  }
}

function radiusOf(sound: SoundMark, strip: Strip, large: boolean): number {
  const most = Math.min(large ? 30 : 18, strip.height / 6);
  return 5 + sound.loudness * (most - 5);
}

function drawSound(context: Context, strip: Strip, sound: SoundMark, large: boolean): void {
  const radius = radiusOf(sound, strip, large);
  const color = SOUND[sound.kind];
  // Half of what sounds right behind is at the other end.
  for (const { x, y } of onBothEnds(strip, place(strip, sound.azimuth, sound.elevation), radius + 5)) {
    disc(context, x, y, radius);
    context.fillStyle = `rgb(${color} / ${0.72 * sound.opacity})`;
    context.fill();
    context.lineWidth = 1.5;
    context.strokeStyle = `rgb(255 255 255 / ${0.85 * sound.opacity})`;
    context.stroke();
    if (sound.kind !== "voice") continue;
    // Told by shape as well as by colour.
    disc(context, x, y, radius + 4);
    context.lineWidth = 2;
    context.strokeStyle = `rgb(${color} / ${sound.opacity})`;
    context.stroke();
  }
}

function boxOf(strip: Strip, sound: SoundMark, large: boolean): Box {
  const { x, y } = place(strip, sound.azimuth, sound.elevation);
  const radius = radiusOf(sound, strip, large);
  return { x: x - radius, y: y - radius, width: 2 * radius, height: 2 * radius };
}

function drawFrame(context: Context, strip: Strip, face: FaceMark): void {
  const { x, y, width, height } = frameOf(strip, face);
  context.lineJoin = "round";
  for (const [color, thick] of [
    ["rgb(0 0 0 / 0.6)", 4],
    [FACE, 2],
  ] as const) {
    context.strokeStyle = color;
    context.lineWidth = thick;
    context.strokeRect(x, y, width, height);
  }
}

function frameOf(strip: Strip, face: FaceMark): Box {
  const { x, y } = place(strip, face.azimuth, face.elevation);
  const [width, height] = [Math.max(9, face.width * scale(strip)), Math.max(11, face.height * scale(strip))];
  return { x: x - width / 2, y: y - height / 2, width, height };
}

function drawFaceName(context: Context, strip: Strip, face: FaceMark, taken: Box[]): void {
  const frame = frameOf(strip, face);
  drawName(context, strip, face.text, frame.x + frame.width / 2, frame.y - 3, FACE, 1, taken);
}

function drawSoundName(context: Context, strip: Strip, sound: SoundMark, taken: Box[]): void {
  const { x, y } = place(strip, sound.azimuth, sound.elevation);
  const top = y - radiusOf(sound, strip, true) - 7;
  drawName(context, strip, sound.text, x, top, "#ffffff", sound.opacity, taken);
}

/** Above `bottom`, or where there is room near it. */
function drawName(
  context: Context,
  strip: Strip,
  text: string,
  x: number,
  bottom: number,
  color: string,
  opacity: number,
  taken: Box[],
): void {
  context.font = `600 11.5px ${FONT}`;
  const width = context.measureText(text).width + 8;
  const height = 15;
  const left = Math.max(1, Math.min(strip.width - width - 1, x - width / 2));
  const at = (y: number) => ({ x: left, y: Math.max(1, Math.min(strip.height - FOOT - height, y)), width, height });
  const places = [0, 8, 16, 24, 32, 48].flatMap((off) => [at(bottom - height - off), at(bottom + BELOW + off)]);
  const box = places.find((one) => !taken.some((other) => overlap(one, other))) ?? places[0]!;
  taken.push(box);
  context.globalAlpha = opacity;
  context.fillStyle = "rgb(10 13 18 / 0.8)";
  context.beginPath();
  context.roundRect(box.x, box.y, width, height, 4);
  context.fill();
  context.fillStyle = color;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, left + width / 2, box.y + height / 2 + 0.5);
  context.globalAlpha = 1;
}

function drawFlash(context: Context, strip: Strip, left: number): void {
  context.lineWidth = 10;
  context.strokeStyle = `rgb(${FLASH} / ${0.9 * left})`;
  context.strokeRect(0, 0, strip.width, strip.height);
}

function onBothEnds(strip: Strip, { x, y }: Point, reach: number): Point[] {
  if (x < reach)
    return [
      { x, y },
      { x: x + strip.width, y },
    ];
  if (x > strip.width - reach)
    return [
      { x, y },
      { x: x - strip.width, y },
    ];
  return [{ x, y }];
}

function disc(context: Context, x: number, y: number, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}

function overlap(a: Box, b: Box): boolean {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

function radians(degrees: number): number {
  return (degrees * Math.PI) / 180;
}
