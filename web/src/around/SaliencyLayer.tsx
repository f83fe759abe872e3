/** What stands out around the head: a faint heat under all marks, and numbered rings over them. */

import type { SaliencyMap, SalientRegions } from "../protocol/types";
import { layer, type Pen } from "./layer";
import { fresh, heat, heatBox, markAt, regionMarks, saliencySummary } from "./saliencyMarks";
import { place } from "./stripProjection";

const RING = "255 150 60";
const HOVER_PX = 16;

/** The picture of the last heat: the strip is painted far more often than one comes. */
let drawn: { of: SaliencyMap; canvas: HTMLCanvasElement } | null = null;

export const heatLayer = layer({
  type: "saliency",
  group: "salient",
  words: () => "",
  draw: drawHeat,
  Marks: () => null,
});

export const salientLayer = layer({
  type: "salient_regions",
  group: "salient",
  words: saliencySummary,
  draw: drawRings,
  Marks,
  hover: (strip, at, message, now) => markAt(regionMarks(message, now), strip, at, HOVER_PX)?.text ?? "",
});

function drawHeat({ context, strip }: Pen, map: SaliencyMap | null, now: number): boolean {
  if (!map || !fresh(map, now)) return false;
  const picture = pictureOf(map);
  if (!picture) return false;
  const box = heatBox(strip, map);
  context.drawImage(picture, box.x, box.y, box.width, box.height);
  return false;
}

function pictureOf(map: SaliencyMap): HTMLCanvasElement | null {
  if (drawn?.of === map) return drawn.canvas;
  const { width, height, pixels } = heat(map);
  if (width === 0) return null;
  const canvas = drawn?.canvas ?? document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d")!.putImageData(new ImageData(pixels, width, height), 0, 0);
  drawn = { of: map, canvas };
  return canvas;
}

function drawRings(pen: Pen, message: SalientRegions | null, now: number): boolean {
  const { context, strip, large } = pen;
  const radius = large ? 13 : 9;
  for (const mark of regionMarks(message, now).reverse()) {
    const { x, y } = place(strip, mark.azimuth, mark.elevation);
    for (const [color, thick] of [
      ["rgb(0 0 0 / 0.6)", 4],
      [`rgb(${RING})`, 2],
    ] as const) {
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.strokeStyle = color;
      context.lineWidth = thick;
      context.stroke();
    }
    context.font = `700 ${large ? 13 : 10.5}px system-ui, 'DejaVu Sans', sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineWidth = 3;
    context.strokeStyle = "rgb(0 0 0 / 0.7)";
    context.strokeText(`${mark.rank}`, x, y + 0.5);
    context.fillStyle = "#ffffff";
    context.fillText(`${mark.rank}`, x, y + 0.5);
    pen.keepOff({ x: x - radius, y: y - radius, width: 2 * radius, height: 2 * radius });
  }
  return false;
}

function Marks({ message, now }: { message: SalientRegions | null; now: number }) {
  return (
    <>
      {regionMarks(message, now).map((mark) => (
        <li
          key={`region ${mark.rank}`}
          data-testid="around-region"
          data-rank={mark.rank}
          data-azimuth={mark.azimuth}
          data-elevation={mark.elevation}
        >
          {mark.text}
        </li>
      ))}
    </>
  );
}
