/** The face's picture: one SVG, made once, whose shapes are set as the pose changes. */

import { type Eye, JOINTS, type Pose, shapesOf } from "./shape";

const SVG = "http://www.w3.org/2000/svg";
const IRIS = 60;

export class FacePicture {
  readonly svg = make("svg", {
    class: "face",
    viewBox: "140 14 720 616",
    role: "img",
    "aria-label": "The robot's face",
    "data-testid": "face",
  });
  private readonly eyes: Record<"left" | "right", EyePicture>;
  private readonly mouth: SVGElement[];
  private readonly tongue: SVGElement;
  private readonly cheeks: SVGElement;

  constructor() {
    const defs = this.add("defs", {});
    defs.innerHTML = GRADIENTS;
    this.cheeks = this.add("g", { class: "cheeks" });
    for (const x of [255, 745]) add(this.cheeks, "ellipse", { cx: `${x}`, cy: "440", rx: "92", ry: "62" });
    this.eyes = { left: new EyePicture(this.svg, "left"), right: new EyePicture(this.svg, "right") };
    const clip = add(add(defs, "clipPath", { id: "mouth" }), "path", {});
    const inside = this.add("path", { class: "mouth" });
    this.tongue = add(this.add("g", { "clip-path": "url(#mouth)" }), "ellipse", {
      class: "tongue",
      rx: "74",
      ry: "42",
    });
    this.mouth = [clip, inside, this.add("path", { class: "lips" })];
  }

  draw(pose: Pose): void {
    const shapes = shapesOf(pose);
    this.eyes.left.draw(shapes.left);
    this.eyes.right.draw(shapes.right);
    for (const path of this.mouth) path.setAttribute("d", shapes.mouth);
    set(this.tongue, { cx: shapes.tongue.x.toFixed(1), cy: shapes.tongue.y.toFixed(1) });
    this.cheeks.setAttribute("opacity", shapes.cheeks.toFixed(2));
    this.svg.dataset["pose"] = JOINTS.map((joint) => pose[joint].toFixed(3)).join(" ");
  }

  private add(name: string, attributes: Record<string, string>): SVGElement {
    return add(this.svg, name, attributes);
  }
}

class EyePicture {
  private readonly outlines: SVGElement[];
  private readonly lid: SVGElement;
  private readonly iris: SVGElement;
  private readonly brow: SVGElement;

  constructor(svg: SVGElement, side: string) {
    const clip = add(add(add(svg, "defs", {}), "clipPath", { id: `${side}-eye` }), "path", {});
    const white = add(svg, "path", { class: "white" });
    const edge = add(svg, "path", { class: "edge" });
    const inside = add(svg, "g", { "clip-path": `url(#${side}-eye)` });
    this.iris = add(inside, "g", {});
    add(this.iris, "circle", { class: "iris", r: `${IRIS}` });
    add(this.iris, "circle", { class: "pupil", r: "31" });
    add(this.iris, "circle", { class: "light", cx: "-18", cy: "-22", r: "13" });
    add(this.iris, "circle", { class: "light faint", cx: "16", cy: "20", r: "7" });
    this.lid = add(svg, "path", { class: "lid" });
    this.brow = add(svg, "path", { class: "brow" });
    this.outlines = [clip, white, edge];
  }

  draw(eye: Eye): void {
    for (const path of this.outlines) path.setAttribute("d", eye.outline);
    this.lid.setAttribute("d", eye.lid);
    this.brow.setAttribute("d", eye.brow);
    this.iris.setAttribute("transform", `translate(${eye.iris.x.toFixed(1)} ${eye.iris.y.toFixed(1)})`);
  }
}

const GRADIENTS = `
  <radialGradient id="iris"><stop offset="0.35" stop-color="#0d6c80"/><stop offset="0.8" stop-color="#27b3c9"/>
    <stop offset="1" stop-color="#0f7f95"/></radialGradient>
  <radialGradient id="white" cx="0.5" cy="0.42" r="0.62"><stop offset="0.6" stop-color="#fdfeff"/>
    <stop offset="1" stop-color="#cfdde6"/></radialGradient>
  <radialGradient id="cheek"><stop offset="0" stop-color="#ff7f7f" stop-opacity="0.55"/>
    <stop offset="1" stop-color="#ff7f7f" stop-opacity="0"/></radialGradient>`;

function add(parent: SVGElement, name: string, attributes: Record<string, string>): SVGElement {
  return parent.appendChild(make(name, attributes));
}

function make(name: string, attributes: Record<string, string>): SVGElement {
  const element = document.createElementNS(SVG, name) as SVGElement;
  set(element, attributes);
  return element;
}

function set(element: SVGElement, attributes: Record<string, string>): void {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
}
