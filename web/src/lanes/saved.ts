/** The lanes as a file: a drawing for a paper (SVG), and its figures as a table (CSV). Pure. */

import { spaced } from "../ui/format";
import { Columns, toColumns } from "./columns";
import type { LaneHistory } from "./history";
import { PAPER } from "./palette";
import { spells } from "./runLengths";
import type { Edges } from "./strip";
import { tickStep } from "./viewport";

const NAMES = 150;
const WIDE = 760;
const ROW = 58;
const GAP = 12;
const AXIS = 44;
const BAND = 5;

/** Of `classes` between `edges`, values from 0 to `scale`: intensity black with points, utility red, 1/φ blue. */
export function lanesSvg(history: LaneHistory, classes: readonly string[], edges: Edges, scale: number): string {
  const high = classes.length * (ROW + GAP) + AXIS;
  const rows = classes.map((name, i) => row(history, name, edges, scale, 8 + i * (ROW + GAP)));
  const out = [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${NAMES + WIDE + 20} ${high}" width="${NAMES + WIDE + 20}" height="${high}" font-family="Helvetica, Arial, sans-serif" font-size="12" fill="${PAPER.words}">`,
    `<rect width="100%" height="100%" fill="${PAPER.ground}"/>`,
    ...rows,
    axis(edges, classes.length * (ROW + GAP)),
    "</svg>",
  ];
  return out.join("\n");
}

function row(history: LaneHistory, name: string, edges: Edges, scale: number, top: number): string {
  const floor = top + ROW;
  const lane = history.lanes.get(name);
  const parts = [
    `<text x="${NAMES - 28}" y="${top + ROW / 2 + 4}" text-anchor="end" font-weight="600">${inXml(spaced(name))}</text>`,
    ...[0, scale / 2, scale].map((value) => {
      const y = floor - (value / scale) * ROW;
      return `<path d="M${NAMES} ${y}H${NAMES + WIDE}" stroke="${PAPER.scale}"/><text x="${NAMES - 6}" y="${y + 3}" text-anchor="end" font-size="9">${value}</text>`;
    }),
  ];
  if (!lane) return parts.join("");
  const span = { ...edges, width: WIDE };
  const columns = new Columns(WIDE);
  const x = (i: number) => round(NAMES + columns.x[i]!);
  const end = (i: number) => round(NAMES + columns.end[i]!);
  toColumns(history, lane.divisor, span, columns);
  for (const [from, to, phi] of runs(columns)) {
    const y = round(floor - ROW / phi);
    parts.push(
      `<rect x="${x(from)}" y="${y}" width="${round(end(to) - x(from))}" height="${round(floor - y)}" fill="${PAPER.rate}"/>`,
    );
    parts.push(`<path d="M${x(from)} ${y}H${end(to)}" stroke="${PAPER.edge}"/>`);
  }
  // What is closed has no rate.
  const path = (unit: number, passing = false) =>
    runs(columns)
      .filter(([, , value]) => !passing || value > 0)
      .map(([from, to, value], i, all) => {
        const joined = i > 0 && columns.x[from]! - columns.end[all[i - 1]![1]]! < 1.5;
        return `${joined ? "L" : "M"}${x(from)} ${round(floor - value * unit)}H${end(to)}`;
      })
      .join("");
  toColumns(history, lane.rate, span, columns);
  parts.push(`<path d="${path(ROW, true)}" fill="none" stroke="${PAPER.measured}" stroke-width="0.7"/>`);
  toColumns(history, lane.utility, span, columns);
  parts.push(
    `<path d="${path(ROW / scale)}" fill="none" stroke="${PAPER.utility}" stroke-width="4" stroke-dasharray="8 4"/>`,
  );
  toColumns(history, lane.intensity, span, columns);
  parts.push(`<path d="${path(ROW / scale)}" fill="none" stroke="${PAPER.intensity}" stroke-width="1.4"/>`);
  for (const [from, , value] of runs(columns))
    parts.push(
      `<circle cx="${x(from)}" cy="${round(floor - (value * ROW) / scale)}" r="2.4" fill="${PAPER.intensity}"/>`,
    );
  spells(history, lane, edges, (state, from, to) => {
    const color = state === "unfulfilled" || state === "inhibited" ? PAPER[state] : PAPER.intended;
    if (state === "undesired" || state === "needed") return;
    const [left, right] = [from, to].map(
      (s) => NAMES + ((Math.max(s, edges.from) - edges.from) / (edges.to - edges.from)) * WIDE,
    );
    const dash =
      state === "degraded" ? ' stroke-dasharray="4 2"' : state === "unfulfilled" ? ' stroke-dasharray="1.5 1.5"' : "";
    const thick = state === "unfulfilled" || state === "inhibited" ? BAND : 2;
    parts.push(
      `<path d="M${round(left!)} ${floor + BAND}H${round(right!)}" stroke="${color}" stroke-width="${thick}"${dash}/>`,
    );
  });
  return parts.join("");
}

/** First and last column of each stretch of one value, and the value. */
function runs(columns: Columns): [from: number, to: number, value: number][] {
  const found: [number, number, number][] = [];
  for (let i = 0; i < columns.length; i++) {
    const last = found.at(-1);
    const value = columns.last[i]!;
    if (last && last[2] === value && columns.x[i]! - columns.end[i - 1]! < 1.5) last[1] = i;
    else found.push([i, i, value]);
  }
  return found;
}

function axis({ from, to }: Edges, top: number): string {
  const every = tickStep(to - from, 10);
  const parts = [`<path d="M${NAMES} ${top + 6}H${NAMES + WIDE}" stroke="${PAPER.words}"/>`];
  for (let s = 0; s <= to - from + 1e-6; s += every) {
    const x = round(NAMES + (s / (to - from)) * WIDE);
    parts.push(
      `<path d="M${x} ${top + 6}v4" stroke="${PAPER.words}"/><text x="${x}" y="${top + 22}" text-anchor="middle" font-size="10">${round(s)}</text>`,
    );
  }
  const begin = new Date(from * 1000).toISOString().replace("T", " ").slice(0, 19);
  parts.push(`<text x="${NAMES + WIDE / 2}" y="${top + 38}" text-anchor="middle">Time (s) since ${begin} UTC</text>`);
  return parts.join("");
}

/** One line per change of a class, with the values that hold from then on; the measured rate is of that instant. */
export function lanesCsv(history: LaneHistory, classes: readonly string[], edges: Edges): string {
  const lines = ["time_s,class,intensity,utility,phi,measured_rate,state,reason"];
  const [first, last] = [Math.max(history.first, history.at(edges.from)), history.at(edges.to)];
  for (const name of classes) {
    const lane = history.lanes.get(name);
    let before = "";
    for (let number = first; lane && number <= last && number >= 0; number++) {
      const slot = number % history.capacity;
      const state = lane.state[slot];
      if (state === undefined) continue;
      const [intensity, utility, phi] = [lane.intensity, lane.utility, lane.divisor].map((of) => cell(of[slot]!));
      const held = [name, intensity, utility, phi].join();
      const now = `${held} ${state} ${lane.text[slot]} ${cell(lane.rate[slot]!)}`;
      if (now === before) continue;
      before = now;
      lines.push(
        `${history.stamps[slot]!.toFixed(3)},${held},${cell(lane.rate[slot]!)},${state},${quoted(lane.text[slot] ?? "")}`,
      );
    }
  }
  return `${lines.join("\n")}\n`;
}

function cell(value: number): string {
  return Number.isNaN(value) ? "" : String(Number(value.toFixed(4)));
}

function quoted(text: string): string {
  return `"${text.replaceAll('"', '""')}"`;
}

function round(value: number): number {
  return Number(value.toFixed(1));
}

function inXml(text: string): string {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
}
