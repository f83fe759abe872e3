/** The program as a graph of modules and channels, from what its load says of them (thesis fig. 4.2). Pure. */

import type { Load, SourceState } from "../protocol/types";
import { spaced } from "../ui/format";

export type Role = Load["modules"][number]["role"];

export interface GraphNode {
  name: string;
  title: string;
  role: Role;
  state: Load["modules"][number]["state"];
  cpu: number;
  budget: number | null;
  /** Whether anything goes in or out of it now. */
  active: boolean;
  /** Channels that it feeds and no module takes: what is for the page or a recording, and what is not wired yet. */
  untaken: string[];
}

export interface GraphEdge {
  from: string;
  to: string;
  channel: string;
  /** The consumer's port. */
  port: string;
  /** φ of the port; null: nothing passes. */
  phi: number | null;
  /** Messages a second on the channel; null: not known, or a channel of events. */
  hz: number | null;
}

export interface Graph {
  nodes: GraphNode[];
  edges: GraphEdge[];
}

/** All modules and the channels between them; `sources` says how fast channels go. */
export function graphOf(load: Load, sources: readonly SourceState[]): Graph {
  const producers = new Map<string, string>();
  for (const { name, outputs } of load.modules)
    for (const { channel } of outputs) if (channel !== null) producers.set(channel, name);
  const rates = new Map(sources.map((each) => [each.channel, each.rate_hz]));
  const edges = load.modules.flatMap(({ name, inputs }) =>
    inputs.flatMap(({ name: port, channel, divisor }) => {
      const from = producers.get(channel);
      if (from === undefined || from === name) return [];
      return [{ from, to: name, channel, port, phi: divisor, hz: rates.get(channel) ?? null }];
    }),
  );
  const busy = new Set(edges.filter(({ phi }) => phi !== null).flatMap(({ from, to }) => [from, to]));
  const titles = load.modules.map(({ title }) => title);
  const alone = (title: string) => titles.indexOf(title) === titles.lastIndexOf(title);
  const taken = new Set(load.modules.flatMap(({ inputs }) => inputs.map(({ channel }) => channel)));
  const nodes = load.modules.map(({ name, title, role, state, cpu, cpu_budget, inputs, outputs }) => ({
    name,
    title: title !== "" && alone(title) ? title : spaced(name),
    role,
    state,
    cpu,
    budget: cpu_budget,
    untaken: outputs.flatMap(({ channel }) => (channel === null || taken.has(channel) ? [] : [channel])),
    active: cpu >= 0.05 || (busy.has(name) && (inputs.length === 0 || inputs.some(({ divisor }) => divisor !== null))),
  }));
  return { nodes, edges };
}

/** The part where something goes on: active modules, and what flows between them. */
export function activeOf({ nodes, edges }: Graph): Graph {
  const shown = new Set(nodes.filter(({ active }) => active).map(({ name }) => name));
  return {
    nodes: nodes.filter(({ name }) => shown.has(name)),
    edges: edges.filter(({ from, to, phi }) => phi !== null && shown.has(from) && shown.has(to)),
  };
}

/** The channels into and out of a module, in words. */
export function around(graph: Graph, name: string): { into: GraphEdge[]; out: GraphEdge[] } {
  return {
    into: graph.edges.filter(({ to }) => to === name),
    out: graph.edges.filter(({ from }) => from === name),
  };
}

/** Where the columns of the figure stand, from what is sensed to what moves. */
export const ROLES: readonly Role[] = ["sensors", "perception", "motivations", "behaviors", "actuation", "other"];
export const BOX = { width: 148, height: 40 } as const;
const ACROSS = 212;
const DOWN = 50;
const TOP = 30;

export interface Arranged {
  width: number;
  height: number;
  columns: { role: Role; x: number }[];
  /** Upper left corners by module. */
  boxes: ReadonlyMap<string, { x: number; y: number }>;
}

/** One column for each role that has modules, each in the order that crosses fewest lines of the columns before it. */
export function arrange({ nodes, edges }: Graph): Arranged {
  const boxes = new Map<string, { x: number; y: number }>();
  const columns = ROLES.map((role) => ({ role, members: nodes.filter((node) => node.role === role) })).filter(
    ({ members }) => members.length > 0,
  );
  columns.forEach(({ members }, column) => {
    const middle = (name: string) => {
      const rows = edges.filter(({ to }) => to === name).flatMap(({ from }) => boxes.get(from)?.y ?? []);
      return rows.length > 0 ? rows.reduce((sum, y) => sum + y, 0) / rows.length : Infinity;
    };
    const ranked = members.map((node) => ({ node, at: middle(node.name) }));
    ranked.sort((a, b) => (a.at === b.at ? a.node.title.localeCompare(b.node.title) : a.at - b.at));
    ranked.forEach(({ node }, row) => boxes.set(node.name, { x: column * ACROSS + 8, y: TOP + row * DOWN }));
  });
  const most = Math.max(0, ...columns.map(({ members }) => members.length));
  return {
    width: Math.max(1, columns.length) * ACROSS - (ACROSS - BOX.width) + 16,
    height: TOP + most * DOWN,
    columns: columns.map(({ role }, column) => ({ role, x: column * ACROSS + 8 })),
    boxes,
  };
}

/** The path of a line between two boxes: from right to left edge; within a column, around on the right. */
export function pathOf(from: { x: number; y: number }, to: { x: number; y: number }): string {
  const [x1, y1, y2] = [from.x + BOX.width, from.y + BOX.height / 2, to.y + BOX.height / 2];
  if (from.x === to.x) {
    const bulge = x1 + 14 + Math.min(34, Math.abs(y2 - y1) / 10);
    return `M${x1} ${y1}C${bulge} ${y1} ${bulge} ${y2} ${x1} ${y2}`;
  }
  const x2 = to.x;
  const bend = x2 > x1 ? (x2 - x1) / 2 : 44;
  return `M${x1} ${y1}C${x1 + bend} ${y1} ${x2 - bend} ${y2} ${x2} ${y2}`;
}
