/** The living graph of the program: sensors, perceptions, behaviors, with rates, filters and load. Boxes explain themselves. */

import { useSignal } from "@preact/signals";
import { useLayoutEffect } from "preact/hooks";
import { named, type Text, t, within } from "../i18n";
import { filterWords } from "../panels/attentionText";
import type { Load } from "../protocol/types";
import { useApp } from "../state/context";
import { number, spaced } from "../ui/format";
import { CloseIcon, EnlargeIcon, ShrinkIcon } from "../ui/icons";
import {
  activeOf,
  around,
  arrange,
  BOX,
  type Graph,
  type GraphEdge,
  type GraphNode,
  graphOf,
  pathOf,
  type Role,
} from "./graphModel";

const COLUMNS: Record<Role, Text> = {
  sensors: "Sensors",
  perception: "Perception",
  motivations: "Motivations",
  behaviors: "Behaviors",
  actuation: "Actuation",
  other: "Others",
};

export function GraphCard({ message: load }: { message: Load | null }) {
  const { store } = useApp();
  const all = useSignal(false);
  const large = useSignal(false);
  const chosen = useSignal<string | null>(null);
  useLayoutEffect(() => (large.value ? store.opened(() => (large.value = false)) : undefined), [large.value]);
  const whole = load && graphOf(load, store.of("status").peek()?.sources ?? []);
  const graph = whole && (all.value ? whole : activeOf(whole));
  const attended = new Set(Object.keys(store.of("intention").value?.filters ?? {}));
  return (
    <section
      class={`card graph ${large.value ? "large" : ""}`}
      aria-label={t("Modules and channels")}
      data-testid="graph"
    >
      <div class="card-head">
        <h2>{t("Modules and channels")}</h2>
        <label class="small">
          <input
            type="checkbox"
            checked={all.value}
            data-testid="graph-all"
            onChange={(event) => (all.value = event.currentTarget.checked)}
          />
          {t("Also what rests")}
        </label>
        <button
          type="button"
          class="icon-button"
          data-testid="graph-large"
          aria-label={large.value ? t("Shrink the graph") : t("Enlarge the graph")}
          aria-pressed={large.value}
          onClick={() => (large.value = !large.value)}
        >
          {large.value ? <ShrinkIcon /> : <EnlargeIcon />}
        </button>
      </div>
      {!graph ? (
        <p class="empty">{t("Waiting for the next figures (once a second)…")}</p>
      ) : (
        <div class="graph-area">
          <Drawing
            graph={graph}
            attended={attended}
            chosen={chosen.value}
            choose={(name) => (chosen.value = name === chosen.peek() ? null : name)}
          />
        </div>
      )}
      {whole && chosen.value !== null && (
        <Explained graph={whole} name={chosen.value} close={() => (chosen.value = null)} />
      )}
      <p class="muted small">
        {t(
          "Lines are what attention filters: thinner, and with “1 of n”, where messages are left out. Press a box for all its channels and what it does. The bar in a box is its share of a core.",
        )}
      </p>
    </section>
  );
}

function Drawing(props: {
  graph: Graph;
  /** Ports whose filters attention sets. */
  attended: ReadonlySet<string>;
  chosen: string | null;
  choose: (name: string) => void;
}) {
  const { graph, attended, chosen, choose } = props;
  const { width, height, columns, boxes } = arrange(graph);
  const touches = ({ from, to }: GraphEdge) => from === chosen || to === chosen;
  const drawn = graph.edges.filter(
    (edge) => touches(edge) || (chosen === null && attended.has(`${edge.to}.${edge.port}`)),
  );
  return (
    <svg
      viewBox={`0 0 ${width} ${height}`}
      width={width}
      height={height}
      role="group"
      aria-label={t("Modules by layer")}
    >
      {columns.map(({ role, x }) => (
        <text key={role} class="graph-column" x={x} y={18}>
          {t(COLUMNS[role])}
        </text>
      ))}
      {drawn.map((edge) => (
        <Line key={keyOf(edge)} edge={edge} boxes={boxes} related={touches(edge)} />
      ))}
      {graph.nodes.map((node) => (
        <Box key={node.name} node={node} at={boxes.get(node.name)!} chosen={node.name === chosen} choose={choose} />
      ))}
    </svg>
  );
}

function keyOf({ from, to, port }: GraphEdge): string {
  return `${from}>${to}.${port}`;
}

function Line(props: { edge: GraphEdge; boxes: ReadonlyMap<string, { x: number; y: number }>; related: boolean }) {
  const { edge, boxes, related } = props;
  const { phi } = edge;
  const [from, to] = [boxes.get(edge.from)!, boxes.get(edge.to)!];
  const words = `${edge.channel}: ${filterWords(edge.port, phi)}`;
  return (
    <g class={`graph-line ${phi === null ? "closed" : ""} ${related ? "related" : ""}`}>
      <path d={pathOf(from, to)} style={{ strokeWidth: phi === null ? 1 : 0.8 + 1.8 / phi }}>
        <title>{edge.hz === null ? words : t("{words}, {rate} a second", { words, rate: number(edge.hz) })}</title>
      </path>
      {phi !== null && phi > 1 && (
        <text x={to.x - 6} y={to.y + BOX.height / 2 - 4} text-anchor="end">
          {t("1 of {phi}", { phi: number(phi) })}
        </text>
      )}
    </g>
  );
}

function Box(props: {
  node: GraphNode;
  at: { x: number; y: number };
  chosen: boolean;
  choose: (name: string) => void;
}) {
  const { node, at, chosen, choose } = props;
  const wrong = node.state === "failed" || node.state === "hung";
  const full = BOX.width - 16;
  return (
    <g
      class={`graph-box ${node.active ? "" : "rests"} ${wrong ? "wrong" : ""} ${chosen ? "chosen" : ""}`}
      transform={`translate(${at.x} ${at.y})`}
      role="button"
      tabindex={0} // tabIndex is no attribute of SVG
      aria-pressed={chosen}
      data-testid={`graph-${node.name}`}
      onClick={() => choose(node.name)}
      onKeyDown={(event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        event.stopPropagation();
        choose(node.name);
      }}
    >
      <title>
        {t("{title}, {state}, {share} % of a core", { title: node.title, state: node.state, share: number(node.cpu) })}
      </title>
      <rect width={BOX.width} height={BOX.height} rx="7" />
      <text x="8" y="18">
        {node.title.length > 20 ? `${node.title.slice(0, 19)}…` : node.title}
      </text>
      <text x="8" y="33" class="graph-cpu">
        {wrong ? named(node.state) : node.cpu >= 0.05 ? t("{share} %", { share: number(node.cpu) }) : ""}
      </text>
      <rect class="graph-bar" x="8" y="37" height="3" width={Math.min(full, (full * node.cpu) / 30)} />
    </g>
  );
}

/** A module in words: what it does with which part of the world, and for whom. */
function Explained({ graph, name, close }: { graph: Graph; name: string; close: () => void }) {
  const { store } = useApp();
  const node = graph.nodes.find((each) => each.name === name);
  if (!node) return null;
  const titles = new Map(graph.nodes.map((each) => [each.name, each.title]));
  const { into, out } = around(graph, name);
  const serves = (store.of("intention").value?.strategies ?? []).filter((strategy) =>
    Object.keys(strategy.filters).some((port) => port.startsWith(`${name}.`)),
  );
  return (
    <div class="graph-explained" data-testid="graph-explained">
      <div class="card-head">
        <h3>{node.title}</h3>
        <button type="button" class="icon-button" aria-label={t("Close")} onClick={close}>
          <CloseIcon />
        </button>
      </div>
      <p class="small">
        <code>{name}</code>: {within(t(COLUMNS[node.role]))}, {named(node.state)},{" "}
        {t("{share} % of a core", { share: number(node.cpu, 2) })}
        {node.budget !== null && t(" (expected: under {budget} %)", { budget: number(node.budget) })}
        {serves.length > 0 &&
          t(". At work for {classes}", {
            classes: [...new Set(serves.map((strategy) => spaced(strategy.class)))].join(", "),
          })}
        .
      </p>
      {into.length > 0 && (
        <ul class="small">
          {into.map((edge) => (
            <li key={keyOf(edge)}>
              {t("from {source}: {filter}", {
                source: titles.get(edge.from) ?? edge.from,
                filter: filterWords(edge.port, edge.phi),
              })}
              {edge.hz !== null && <span class="muted"> {t("({rate} a second come)", { rate: number(edge.hz) })}</span>}
            </li>
          ))}
        </ul>
      )}
      {out.length > 0 && (
        <p class="small">
          {t("to {names}", { names: [...new Set(out.map((edge) => titles.get(edge.to)))].join(", ") })}
        </p>
      )}
      {node.untaken.length > 0 && (
        <p class="small muted">{t("to no module: {channels}", { channels: node.untaken.join(", ") })}</p>
      )}
    </div>
  );
}
