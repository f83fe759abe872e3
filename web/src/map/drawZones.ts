/** Draws zones, and the one that is being made. */

import type { Zone } from "../protocol/types";
import { type Context, disc, drawHandle, drawLabel, FONT, stroke, trace } from "./canvas";
import * as colors from "./colors";
import type { Point } from "./mapProjection";
import type { Act } from "./mapTools";
import { cornersOf, middle } from "./zoneList";

/** While its corner is being dragged, as it would be. */
export function moving(zone: Zone, act: Act): Zone {
  if (act.kind !== "corner" || act.handle.zone !== zone.name) return zone;
  const polygon = zone.polygon.map((corner, i): [number, number] =>
    i === act.handle.index ? [act.to.x, act.to.y] : corner,
  );
  return { ...zone, polygon };
}

export function drawZone(context: Context, zone: Zone, at: (point: Point) => Point, selected: boolean): void {
  const corners = cornersOf(zone).map(at);
  const color = zone.kind === "slow" ? colors.SLOW : colors.KEEP_OUT;
  trace(context, corners, true);
  context.fillStyle = pattern(context, zone.kind);
  context.fill();
  context.lineWidth = selected ? 3 : 1.75;
  context.strokeStyle = color;
  context.setLineDash(zone.kind === "slow" ? [7, 4] : []);
  context.stroke();
  context.setLineDash([]);
  if (selected) for (const corner of corners) drawHandle(context, corner, color);
  const wide = Math.max(...corners.map(({ x }) => x)) - Math.min(...corners.map(({ x }) => x));
  const text = zone.kind === "slow" ? `${zone.name} · ${Math.round(zone.speed * 100)} %` : zone.name;
  context.font = `600 11.5px ${FONT}`;
  if (selected || context.measureText(text).width < wide + 16) drawLabel(context, at(middle(zone)), text, color);
}

/** Keep-out is hatched, slow is dotted: distinguished without their colours. */
function pattern(context: Context, kind: Zone["kind"]): CanvasPattern | string {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 10;
  const pen = tile.getContext("2d")!;
  if (kind === "slow") {
    pen.fillStyle = "rgb(240 228 66 / 0.1)";
    pen.fillRect(0, 0, 10, 10);
    pen.fillStyle = "rgb(240 228 66 / 0.65)";
    disc(pen, { x: 3, y: 3 }, 1.3);
    pen.fill();
  } else {
    pen.fillStyle = "rgb(255 138 76 / 0.16)";
    pen.fillRect(0, 0, 10, 10);
    pen.strokeStyle = "rgb(255 138 76 / 0.75)";
    pen.lineWidth = 1.6;
    pen.beginPath();
    for (const off of [-10, 0, 10]) stroke(pen, { x: off, y: 10 }, { x: off + 10, y: 0 });
    pen.stroke();
  }
  return context.createPattern(tile, "repeat") ?? "rgb(255 255 255 / 0.15)";
}

export function drawSketch(context: Context, corners: Point[], color: string): void {
  trace(context, corners, corners.length > 2);
  context.fillStyle = "rgb(255 255 255 / 0.12)";
  if (corners.length > 2) context.fill();
  context.lineWidth = 2;
  context.strokeStyle = color;
  context.setLineDash([4, 4]);
  context.stroke();
  context.setLineDash([]);
  for (const corner of corners) drawHandle(context, corner, color);
}
