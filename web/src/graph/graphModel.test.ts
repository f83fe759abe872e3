import { expect, test } from "vitest";
import type { Load } from "../protocol/types";
import { activeOf, around, arrange, BOX, graphOf, pathOf } from "./graphModel";

const roles: Record<string, string> = {
  Camera: "sensors",
  Faces: "perception",
  Voices: "perception",
  Gaze: "behaviors",
};
const module = (name: string, inputs: [string, string, number | null][], outputs: string[], cpu = 0) => ({
  name,
  role: roles[name],
  title: "",
  state: "running",
  cpu,
  cpu_budget: null,
  inputs: inputs.map(([port, channel, divisor]) => ({ name: port, channel, divisor })),
  outputs: outputs.map((channel) => ({ name: channel, channel })),
});
const load = {
  modules: [
    module("Camera", [], ["images"]),
    module("Faces", [["images", "images", 2]], ["faces"], 20),
    module("Voices", [["audio", "sound", null]], ["voices"]),
    module(
      "Gaze",
      [
        ["faces", "faces", null],
        ["own", "gaze", 1],
      ],
      ["gaze"],
    ),
  ],
} as unknown as Load;
const graph = graphOf(load, [{ channel: "images", rate_hz: 15 } as never]);

test("modules are joined by channels, at the φ of the port and the rate of the channel", () => {
  expect(graph.edges).toEqual([
    { from: "Camera", to: "Faces", channel: "images", port: "images", phi: 2, hz: 15 },
    { from: "Faces", to: "Gaze", channel: "faces", port: "faces", phi: null, hz: null },
  ]);
});

test("channels that no module takes are known", () => {
  const untaken = Object.fromEntries(graph.nodes.map((node) => [node.name, node.untaken]));
  expect(untaken).toEqual({ Camera: [], Faces: [], Voices: ["voices"], Gaze: [] });
});

test("where nothing goes on is left out", () => {
  const active = activeOf(graph);
  expect(active.nodes.map(({ name }) => name)).toEqual(["Camera", "Faces"]);
  expect(active.edges.map(({ channel }) => channel)).toEqual(["images"]);
});

test("columns go from what is sensed to what moves, and no box lies on another", () => {
  const { boxes, columns, width, height } = arrange(graph);
  expect(columns.map(({ role }) => role)).toEqual(["sensors", "perception", "behaviors"]);
  const x = (name: string) => boxes.get(name)!.x;
  expect(x("Camera")).toBeLessThan(x("Faces"));
  expect(x("Faces")).toBe(x("Voices"));
  expect(x("Faces")).toBeLessThan(x("Gaze"));
  expect(Math.abs(boxes.get("Faces")!.y - boxes.get("Voices")!.y)).toBeGreaterThan(BOX.height);
  for (const { x, y } of boxes.values()) {
    expect(x + BOX.width).toBeLessThanOrEqual(width);
    expect(y + BOX.height).toBeLessThanOrEqual(height);
  }
});

test("two modules of one title go by their names", () => {
  const twice = load.modules.map((each) => ({ ...each, title: each.name === "Camera" ? "Kinect" : "Joint control" }));
  const titles = graphOf({ ...load, modules: twice }, []).nodes.map(({ title }) => title);
  expect(titles).toEqual(["Kinect", "Faces", "Voices", "Gaze"]);
});

test("an empty graph has no columns, and a line leads from edge to edge", () => {
  expect(arrange({ nodes: [], edges: [] }).columns).toEqual([]);
  expect(pathOf({ x: 0, y: 0 }, { x: 300, y: 50 })).toMatch(/^M148 20C.* 300 70$/);
  expect(pathOf({ x: 300, y: 0 }, { x: 0, y: 0 })).toMatch(/^M448 20C.* 0 20$/);
});

test("a module's channels differ by their direction", () => {
  const { into, out } = around(graph, "Faces");
  expect([into.map(({ from }) => from), out.map(({ to }) => to)]).toEqual([["Camera"], ["Gaze"]]);
});
