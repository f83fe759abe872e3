/** The frame's half of what page and 3D view say to each other: the script as the console injects it. */

import { afterEach, beforeEach, expect, test, vi } from "vitest";
import HTML from "../../../app/console/view/inject.html?raw";

const SCRIPT = /<script>([\s\S]*)<\/script>/.exec(HTML as string)![1]!;
const PAGE = "http://robot:8080";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

/** A canvas whose context says that it is of `renderer`, and finishes each frame `drawMs` after its start. */
function canvases(renderer: string, drawMs: { value: number }) {
  const context = {
    getExtension: () => ({ loseContext: () => undefined }),
    getParameter: () => renderer,
    SIGNALED: true,
    fenceSync: () => performance.now(),
    flush: () => undefined,
    getSyncParameter: (started: number) => performance.now() - started >= drawMs.value,
    deleteSync: () => undefined,
  };
  return class {
    isConnected = true;
    getContext(_type: string): typeof context {
      return context;
    }
  };
}

/** The connection over which its pulse comes. */
interface Pulse {
  onmessage?: (event: { data: string }) => void;
  send: ReturnType<typeof vi.fn>;
}

/** The script in a window of little more than what it uses. */
function injected(pageOrigin = PAGE, renderer = "", drawMs = { value: 0 }, onFrame = vi.fn()) {
  const sockets: Pulse[] = [];
  class OurSocket implements Pulse {
    readyState = 1;
    send = vi.fn();
    constructor() {
      sockets.push(this);
    }
  }
  const HTMLCanvasElement = canvases(renderer, drawMs);
  const parent = { postMessage: vi.fn() };
  const target = new EventTarget();
  const location = { href: "http://robot:8081/viser/", origin: "http://robot:8081", pathname: "/viser/" };
  const document = Object.assign(new EventTarget(), {
    hidden: false,
    createElement: () => new HTMLCanvasElement(),
  });
  const nextFrame = (run: (now: number) => void) => setTimeout(() => run(performance.now()));
  const window = { parent, requestAnimationFrame: nextFrame as (run: (now: number) => void) => unknown };
  const everyPeriod = vi.fn(() => 1);
  const globals = {
    window,
    location,
    document,
    setInterval: everyPeriod,
    history: { replaceState: vi.fn() },
    requestAnimationFrame: onFrame,
    WebSocket: OurSocket,
    HTMLCanvasElement,
    addEventListener: target.addEventListener.bind(target),
    dispatchEvent: target.dispatchEvent.bind(target),
  };
  new Function(...Object.keys(globals), SCRIPT.replace("{page origin}", pageOrigin))(...Object.values(globals));
  const tell = (data: unknown, { origin = PAGE, source = parent as object } = {}) =>
    target.dispatchEvent(Object.assign(new Event("message"), { data, origin, source }));
  const press = (type: "keydown" | "keyup", code: string, held = {}) => {
    const plain = { key: code, repeat: false, ctrlKey: false, altKey: false, metaKey: false, shiftKey: false };
    const event = Object.assign(new Event(type, { cancelable: true }), { code, ...plain, ...held });
    target.dispatchEvent(event);
    return event.defaultPrevented;
  };
  const point = (type: string, x: number, y: number, atMs: number, more: object = {}) => {
    const canvas = { tagName: "CANVAS", getBoundingClientRect: () => ({ left: 10, top: 20, width: 400, height: 200 }) };
    const plain = { isPrimary: true, button: 0, pointerId: 1, clientX: x, clientY: y, timeStamp: atMs, target: canvas };
    const event = new Event(type);
    for (const [name, value] of Object.entries({ ...plain, ...more })) Object.defineProperty(event, name, { value });
    target.dispatchEvent(event);
  };
  const said = () => parent.postMessage.mock.calls.map(([message]) => (message as { type: string }).type);
  return { parent, target, sockets, tell, press, point, said, everyPeriod, window, HTMLCanvasElement };
}

/** What draws at each frame that it gets; when (ms) it drew. */
function viser({ window, HTMLCanvasElement }: ReturnType<typeof injected>): number[] {
  new HTMLCanvasElement().getContext("webgl2");
  const drawn: number[] = [];
  const draw = () => {
    drawn.push(performance.now());
    window.requestAnimationFrame(draw);
  };
  window.requestAnimationFrame(draw);
  return drawn;
}

const SOFTWARE = "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)";
/** Frames drawn in 10 s. */
const frames = (drawn: number[]) => {
  const before = drawn.length;
  vi.advanceTimersByTime(10_000);
  return drawn.length - before;
};

test.each([
  ["fast", 10, 38, 40], // 4 a second at most
  ["slow", 100, 22, 25], // a quarter of the time
  ["very slow", 400, 9, 11], // once a second
])("without a card, frames that are %s to draw come by what drawing takes", (_, took, fewest, most) => {
  const count = frames(viser(injected(PAGE, SOFTWARE, { value: took })));
  expect(count).toBeGreaterThanOrEqual(fewest);
  expect(count).toBeLessThanOrEqual(most);
});

test("without a card, who drives gets the processor: frames come half as often, and none right after a key", () => {
  const scene = injected(PAGE, SOFTWARE, { value: 80 });
  const drawn = viser(scene);
  const before = frames(drawn);
  scene.tell({ type: "driving", driving: true });
  const pressed = performance.now();
  const during = frames(drawn);
  expect(drawn.filter((at) => pressed < at && at < pressed + 200)).toEqual([]);
  expect(during).toBeLessThan(0.6 * before);
  expect(during).toBeGreaterThan(0.4 * before);
  scene.tell({ type: "driving", driving: false });
  expect(frames(drawn)).toBeGreaterThan(0.9 * before);
});

test("without a card, a view that a hand turns or that goes elsewhere takes no rest for a while", () => {
  const scene = injected(PAGE, SOFTWARE, { value: 200 });
  const drawn = viser(scene);
  const within = (ms: number) => {
    const before = drawn.length;
    vi.advanceTimersByTime(ms);
    return drawn.length - before;
  };
  expect(within(4000)).toBeLessThanOrEqual(6);
  scene.tell({ type: "viewpoint", viewpoint: "top", number: 1 });
  expect(within(2000)).toBeGreaterThanOrEqual(6);
  expect(within(4000)).toBeLessThanOrEqual(6);
  scene.target.dispatchEvent(new Event("wheel"));
  expect(within(2000)).toBeGreaterThanOrEqual(6);
});

test("a frame that never finishes holds up the view for a while only", () => {
  const drawMs = { value: Number.POSITIVE_INFINITY };
  const drawn = viser(injected(PAGE, SOFTWARE, drawMs));
  vi.advanceTimersByTime(2000);
  expect(drawn).toHaveLength(1);
  drawMs.value = 10;
  expect(frames(drawn)).toBeGreaterThan(10);
});

test("a card draws each frame", () => {
  const scene = injected(PAGE, "ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)");
  const drawn = viser(scene);
  vi.advanceTimersByTime(100);
  expect(drawn.length).toBeGreaterThan(50);
});

test.each([
  ["7 1764.250", [{ type: "shown", stamp: 1764.25 }]],
  ["7", []], // nothing is drawn yet
])("the pulse '%s' is answered two frames on, and the page hears of when it is what is seen then", (data, said) => {
  const nextFrame = vi.fn();
  const { parent, sockets } = injected(PAGE, "", { value: 0 }, nextFrame);
  const drawFrame = () => nextFrame.mock.calls.splice(0).forEach(([run]) => (run as (now: number) => void)(0));
  const heard = () => parent.postMessage.mock.calls.map(([message]) => message as { type: string });
  sockets[0]!.onmessage!({ data });
  drawFrame();
  expect(sockets[0]!.send).not.toHaveBeenCalled();
  drawFrame();
  expect(heard().filter(({ type }) => type === "shown")).toEqual(said);
  expect(sockets[0]!.send).toHaveBeenCalledWith(expect.stringMatching(/^7 [0-9.]+$/));
});

test("it speaks to the page of one origin alone", () => {
  const { parent, target, press } = injected();
  target.dispatchEvent(new Event("load"));
  press("keydown", "KeyW");
  expect(parent.postMessage.mock.calls.map(([, origin]) => origin)).toEqual([PAGE, PAGE]);
});

test("on the page's own port that is its own origin", () => {
  const { parent, target } = injected("");
  target.dispatchEvent(new Event("load"));
  expect(parent.postMessage).toHaveBeenCalledWith({ type: "ready" }, "http://robot:8081");
});

test("it hears the page, and no page of another origin and no other window", () => {
  const { tell, press } = injected();
  const keys = { type: "keys", codes: ["KeyW"] };
  tell(keys, { origin: "http://robot:8081" });
  tell(keys, { origin: "http://evil.example" });
  tell(keys, { source: {} });
  expect(press("keydown", "KeyW")).toBe(false);
  tell(keys);
  expect(press("keydown", "KeyW")).toBe(true);
});

test("the page's keys are kept from viser, but not shortcuts of the browser; all are passed on", () => {
  const { tell, press, said } = injected();
  tell({ type: "keys", codes: ["KeyW"] });
  expect(press("keydown", "KeyW", { ctrlKey: true })).toBe(false);
  expect(press("keydown", "KeyM")).toBe(false);
  expect(press("keyup", "KeyW")).toBe(true);
  expect(said()).toEqual(["key", "key", "key"]);
});

test("while a key is held it says so again and again, and once more when none is", () => {
  const { parent, press, everyPeriod } = injected();
  press("keydown", "KeyW");
  const again = () => (everyPeriod.mock.calls as unknown as [() => void][]).forEach(([run]) => run());
  again();
  expect(parent.postMessage).toHaveBeenLastCalledWith({ type: "held", codes: ["KeyW"] }, PAGE);
  press("keyup", "KeyW");
  again();
  expect(parent.postMessage).toHaveBeenLastCalledWith({ type: "held", codes: [] }, PAGE);
});

test.each(["blur", "pagehide"])("its %s is said at once", (type) => {
  const { parent, target, press } = injected();
  press("keydown", "KeyW");
  target.dispatchEvent(new Event(type));
  expect(parent.postMessage).toHaveBeenLastCalledWith({ type: "blur" }, PAGE);
});

/** What it says of clicks. */
function picks({ parent }: ReturnType<typeof injected>): Record<string, unknown>[] {
  const all = parent.postMessage.mock.calls.map(([message]) => message as Record<string, unknown>);
  return all.filter(({ type }) => type === "pick");
}

test("a short press that stays where it is is a click, at shares of the canvas", () => {
  const scene = injected();
  scene.point("pointerdown", 110, 170, 1000);
  scene.point("pointermove", 113, 167, 1100); // a hand trembles
  scene.point("pointerup", 112, 168, 1399);
  expect(picks(scene)).toEqual([{ type: "pick", viewer: expect.stringMatching(/^[0-9a-f]{24}$/), u: 0.25, v: 0.75 }]);
  expect(scene.parent.postMessage.mock.calls.every(([, origin]) => origin === PAGE)).toBe(true);
});

test("the next click is another one", () => {
  const scene = injected();
  for (const at of [1000, 1150]) {
    scene.point("pointerdown", 210, 120, at);
    scene.point("pointerup", 210, 120, at + 60);
  }
  expect(picks(scene).map(({ u, v }) => [u, v])).toEqual([
    [0.5, 0.5],
    [0.5, 0.5],
  ]);
});

type Scene = ReturnType<typeof injected>;
test.each<[string, (scene: Scene) => void]>([
  [
    "goes away and comes back",
    ({ point }) => {
      point("pointermove", 130, 170, 1050);
      point("pointerup", 110, 170, 1100);
    },
  ],
  ["ends 5 px away", ({ point }) => point("pointerup", 113, 174, 1100)],
  ["lasts 400 ms", ({ point }) => point("pointerup", 110, 170, 1400)],
  [
    "is joined by another finger",
    ({ point }) => {
      point("pointerdown", 300, 100, 1050, { pointerId: 2, isPrimary: false });
      point("pointerup", 300, 100, 1100, { pointerId: 2, isPrimary: false });
      point("pointerup", 110, 170, 1120);
    },
  ],
  [
    "the browser takes for its own",
    ({ point }) => {
      point("pointercancel", 110, 170, 1050);
      point("pointerup", 110, 170, 1100);
    },
  ],
])("a press that %s turns the view, and is no click", (_, goOn) => {
  const scene = injected();
  scene.point("pointerdown", 110, 170, 1000);
  goOn(scene);
  expect(picks(scene)).toEqual([]);
});

test.each([
  ["the right button", { button: 2 }],
  ["Shift held", { shiftKey: true }],
  ["Ctrl held", { ctrlKey: true }],
  ["the pointer on a button of viser's", { target: { tagName: "BUTTON" } }],
])("a press with %s is no click", (_, more) => {
  const scene = injected();
  scene.point("pointerdown", 110, 170, 1000, more);
  scene.point("pointerup", 110, 170, 1100, more);
  expect(picks(scene)).toEqual([]);
});

test("a hand on the camera, and its wheel, are said before the click", () => {
  const scene = injected();
  scene.point("pointerdown", 110, 170, 1000);
  scene.point("pointerup", 110, 170, 1100);
  expect(scene.said()).toEqual(["hand", "hand", "pick"]);
  scene.target.dispatchEvent(new Event("wheel"));
  expect(scene.parent.postMessage).toHaveBeenLastCalledWith({ type: "hand", down: false }, PAGE);
});
