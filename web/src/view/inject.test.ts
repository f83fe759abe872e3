/** The frame's half of what page and 3D view say to each other: the script as the console injects it. */

import { expect, test, vi } from "vitest";
import HTML from "../../../app/console/view/inject.html?raw";

const SCRIPT = /<script>([\s\S]*)<\/script>/.exec(HTML as string)![1]!;
const PAGE = "http://robot:8080";

/** The script in a window of little more than what it uses. */
function injected(pageOrigin = PAGE) {
  const parent = { postMessage: vi.fn() };
  const target = new EventTarget();
  const location = { href: "http://robot:8081/viser/", origin: "http://robot:8081", pathname: "/viser/" };
  const document = Object.assign(new EventTarget(), {
    hidden: false,
    createElement: () => ({ getContext: () => null }),
  });
  const window = { parent, requestAnimationFrame: vi.fn() };
  const everyPeriod = vi.fn(() => 1);
  const globals = {
    window,
    location,
    document,
    setInterval: everyPeriod,
    history: { replaceState: vi.fn() },
    requestAnimationFrame: vi.fn(),
    WebSocket: class {},
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
  const said = () => parent.postMessage.mock.calls.map(([message]) => (message as { type: string }).type);
  return { parent, target, tell, press, said, everyPeriod };
}

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
