/** Draws the strip of all directions: the picture ahead, a grid where there is none, and what was perceived. */

import { t } from "../i18n";
import type { Box, Name, Pen } from "./layer";
import { namePlace } from "./namePlaces";
import { type Point, pictureBox, place, type Strip, scale } from "./stripProjection";

export interface Shown {
  /** Null: there is none. */
  picture: HTMLCanvasElement | null;
  old: boolean;
  /** Names of marks, and degrees along the edge. */
  large: boolean;
  /** What lies over it of the page: names keep off it, too. */
  covered: readonly Box[];
}

const FOOT = 17;
/** px; on less, figures would run into the words. */
const NUMBERED = 640;
/** px between two words. */
const APART = 6;
const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif";
const WORDS = [
  { degrees: 180, text: "behind", align: "left" },
  { degrees: 90, text: "left", align: "center" },
  { degrees: 0, text: "ahead", align: "center" },
  { degrees: -90, text: "right", align: "center" },
  { degrees: -180, text: "behind", align: "right" },
] as const;

type Context = CanvasRenderingContext2D;

/** `marks` draws what is perceived. Names come over all marks, and keep off them. */
export function draw(context: Context, strip: Strip, shown: Shown, marks: (pen: Pen) => void): void {
  context.fillStyle = "#0b0f15";
  context.fillRect(0, 0, strip.width, strip.height);
  drawGrid(context, strip);
  if (shown.picture) drawPicture(context, strip, shown.picture, shown.old);
  drawFoot(context, strip, shown.large);
  const taken: Box[] = [...shown.covered];
  const names: Name[] = [];
  const over: (() => void)[] = [];
  marks({
    context,
    strip,
    large: shown.large,
    named: shown.large && strip.width >= NUMBERED,
    keepOff: (box) => taken.push(box),
    name: (name) => names.push(name),
    over: (drawn) => over.push(drawn),
  });
  for (const name of names) drawName(context, strip, name, taken);
  for (const drawn of over) drawn();
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
  const widths = WORDS.map(({ text }) => context.measureText(t(text)).width);
  // Between the middle and an end of the strip are half of a word, a whole one and another whole one.
  const crowded = widths[0]! + widths[1]! + widths[2]! / 2 + 3 * APART > strip.width / 2;
  for (const { degrees, text, align } of WORDS) {
    if (crowded && Math.abs(degrees) === 90) continue;
    context.textAlign = align;
    const x = strip.width / 2 - radians(degrees) * scale(strip);
    context.fillText(t(text), x + (align === "left" ? 5 : align === "right" ? -5 : 0), top + 9);
  }
}

/** Above `bottom`, or where there is room near it; in short, where there is room for that alone. */
function drawName(context: Context, strip: Strip, name: Name, taken: Box[]): void {
  context.font = `600 11.5px ${FONT}`;
  const sized = (text: string) => ({ text, width: context.measureText(text).width + 8, height: 15 });
  const bounds = { width: strip.width, height: strip.height - FOOT };
  const { color, opacity } = name;
  const {
    name: { text },
    box,
  } = namePlace([sized(name.text), sized(name.short ?? name.text)], name, bounds, taken);
  taken.push(box);
  context.globalAlpha = opacity;
  context.fillStyle = "rgb(10 13 18 / 0.8)";
  context.beginPath();
  context.roundRect(box.x, box.y, box.width, box.height, 4);
  context.fill();
  context.fillStyle = color;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, box.x + box.width / 2, box.y + box.height / 2 + 0.5);
  context.globalAlpha = 1;
}

function radians(degrees: number): number {
  return (degrees * Math.PI) / 180;
}
