/** Faces, sounds and loud noises on the strip. */

import type { Perceived } from "../protocol/types";
import { type Box, layer, type Pen } from "./layer";
import { type FaceMark, faceMarks, flash, type SoundKind, type SoundMark, soundMarks, summary } from "./perceptMarks";
import { type Point, place, type Strip, scale } from "./stripProjection";

/** As in the 3D view. */
const SOUND: Record<SoundKind, string> = { voice: "235 45 40", sound: "240 150 40", unjudged: "150 156 168" };
const FACE = "rgb(70 225 140)";
const FLASH = "255 214 90";

type Context = CanvasRenderingContext2D;

export const perceivedLayer = layer({
  type: "perceived",
  words: (perceived, now) => summary(faceMarks(perceived), soundMarks(perceived, now), flash(perceived, now) > 0),
  draw,
  Marks,
});

function draw(pen: Pen, perceived: Perceived | null, now: number): boolean {
  const { context, strip, large } = pen;
  const faces = faceMarks(perceived);
  const sounds = soundMarks(perceived, now);
  const left = flash(perceived, now);
  for (const face of faces) pen.keepOff(frameOf(strip, face));
  for (const sound of sounds) pen.keepOff(boxOf(strip, sound, large));
  for (const sound of sounds) drawSound(context, strip, sound, large);
  for (const face of faces) drawFrame(context, strip, face);
  for (const face of [...faces].reverse()) {
    const { x, y, width } = frameOf(strip, face);
    pen.name({ text: face.text, short: face.short, x: x + width / 2, bottom: y - 3, color: FACE, opacity: 1 });
  }
  if (pen.named)
    for (const sound of sounds) {
      const { x, y } = place(strip, sound.azimuth, sound.elevation);
      const bottom = y - radiusOf(sound, strip, true) - 7;
      pen.name({ text: sound.text, x, bottom, color: "#ffffff", opacity: sound.opacity });
    }
  if (left > 0) pen.over(() => drawFlash(context, strip, left));
  return left > 0 || sounds.some((sound) => !sound.active);
}

function Marks({ message, now }: { message: Perceived | null; now: number }) {
  return (
    <>
      {faceMarks(message).map((face) => (
        <li
          key={`face ${face.track}`}
          data-testid="around-face"
          data-track={face.track}
          data-azimuth={face.azimuth}
          data-elevation={face.elevation}
          data-range={face.range ?? ""}
        >
          {face.text}
        </li>
      ))}
      {soundMarks(message, now).map((sound) => (
        <li
          key={`sound ${sound.track}`}
          data-testid="around-sound"
          data-track={sound.track}
          data-azimuth={sound.azimuth}
          data-elevation={sound.elevation}
          data-kind={sound.kind}
          data-active={sound.active}
        >
          {sound.text}
        </li>
      ))}
    </>
  );
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
    // Distinguished by shape as well as by colour.
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
