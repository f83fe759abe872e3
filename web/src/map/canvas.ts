/** Strokes that several drawings of the map are made of. */

import type { Point } from "./mapProjection";

export type Context = CanvasRenderingContext2D;
export const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif";

export function trace(context: Context, points: readonly Point[], closed: boolean): void {
  context.beginPath();
  points.forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (closed) context.closePath();
}

export function stroke(context: Context, from: Point, to: Point): void {
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
}

export function disc(context: Context, { x, y }: Point, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}

export function outlined(context: Context, text: string, x: number, y: number, color: string): void {
  context.lineJoin = "round";
  context.lineWidth = 3.5;
  context.strokeStyle = "rgb(10 13 18 / 0.9)";
  context.strokeText(text, x, y);
  context.fillStyle = color;
  context.fillText(text, x, y);
}

export function drawLabel(context: Context, { x, y }: Point, text: string, color: string): void {
  context.font = `600 11.5px ${FONT}`;
  const width = context.measureText(text).width + 10;
  context.fillStyle = "rgb(10 13 18 / 0.82)";
  context.beginPath();
  context.roundRect(x - width / 2, y - 9, width, 18, 5);
  context.fill();
  context.fillStyle = color;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, x, y + 0.5);
}

export function drawHandle(context: Context, { x, y }: Point, color: string): void {
  context.fillStyle = "#0b0f15";
  context.strokeStyle = color;
  context.lineWidth = 2;
  context.beginPath();
  context.rect(x - 4.5, y - 4.5, 9, 9);
  context.fill();
  context.stroke();
}
