import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import type { PlaybackController } from "../playback/playbackController";
import type { ToRobot } from "../protocol/types";
import type { Message } from "../state/latest";
import type { Session } from "../state/session";
import { createStore } from "../state/store";
import { DriveController } from "./driveController";

beforeEach(() => void vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => {} }));
afterEach(() => void vi.unstubAllGlobals());

/** What a key is pressed on: nothing in particular, a button, or a field. */
function target(kind: "page" | "button" | "field" = "page"): EventTarget {
  const matches = { page: "", button: "button", field: "textarea" }[kind];
  return Object.assign(new EventTarget(), {
    closest: (selector: string) => (matches && selector.split(", ").includes(matches) ? {} : null),
  });
}

function heldKeys({ going = false, on = target() } = {}) {
  const sent: ToRobot[] = [];
  const session = { send: (message: ToRobot) => sent.push(message) } as unknown as Session;
  const store = createStore();
  const drive = new DriveController(store, session, {} as PlaybackController);
  const stop = vi.fn(() => going);
  drive.onStop = stop;
  drive.listenTo(on as unknown as Window);
  drive.input({ type: "allow", allowed: true });
  const press = (type: "keydown" | "keyup", code: string, repeat = false) => {
    const event = Object.assign(new Event(type, { cancelable: true }), { code, key: code, repeat });
    on.dispatchEvent(event);
    return event.defaultPrevented;
  };
  return { drive, stop, press, sent, session, store };
}

describe("Space", () => {
  test("lets go of the wheel and ends the trip", () => {
    const { drive, press, sent, stop } = heldKeys({ going: true });
    press("keydown", "KeyW");
    expect(drive.state.value.command.held).toBe(true);
    press("keydown", "Space");
    expect(drive.state.value.command.held).toBe(false);
    expect(sent.at(-1)).toMatchObject({ type: "drive", held: false });
    expect(stop).toHaveBeenCalledTimes(1);
  });

  test("ends the trip on a page that holds nothing, once", () => {
    const { press, stop } = heldKeys({ going: true });
    press("keydown", "Space");
    press("keydown", "Space", true);
    expect(stop).toHaveBeenCalledTimes(1);
  });

  test("presses no button while anything drives, or that might send the robot off again", () => {
    const { press } = heldKeys({ going: true, on: target("button") });
    expect(press("keydown", "Space")).toBe(true);
    expect(press("keydown", "Space", true)).toBe(true);
    expect(press("keyup", "Space")).toBe(true);
  });

  test("presses the button of a robot that stands", () => {
    const { press, stop } = heldKeys({ on: target("button") });
    expect(press("keydown", "Space")).toBe(false);
    expect(press("keyup", "Space")).toBe(false);
    expect(stop).toHaveBeenCalledTimes(1);
  });

  test("is a blank in a field", () => {
    const { press, stop } = heldKeys({ going: true, on: target("field") });
    expect(press("keydown", "Space")).toBe(false);
    expect(stop).not.toHaveBeenCalled();
  });
});

describe("commands that come late", () => {
  const waits = "Commands arrive up to 3.0 s late: driving waits.";

  test("are not sent, and the page says why; what was held must be pressed again", () => {
    const { drive, press, sent, store } = heldKeys();
    store.link.value = { ...store.link.peek(), phase: "live" };
    const status = { type: "status", guard: { e_stopped: false }, driver: null } as unknown as Message<"status">;
    store.latest.put(status);
    expect(drive.refusal.value).toBe(null);
    press("keydown", "KeyW");
    store.latest.put({ ...status, waits });
    expect(drive.refusal.value).toBe(waits);
    drive.input({ type: "allow", allowed: drive.refusal.value === null });
    expect(sent.at(-1)).toMatchObject({ type: "drive", held: false });
    press("keydown", "KeyW", true);
    press("keydown", "KeyD");
    expect(sent.at(-1)).toMatchObject({ type: "drive", held: false });
    expect(store.notices.value.at(-1)?.text).toBe(waits);
    store.latest.put({ ...status, waits: "" });
    expect(drive.refusal.value).toBe(null);
  });
});

describe("Escape with the help open", () => {
  function open({ going = false, state = "idle", live = true } = {}) {
    const made = heldKeys({ going });
    const eStop = vi.fn();
    Object.assign(made.session, { eStop });
    made.store.latest.put({ type: "status", guard: { state } } as unknown as Message<"status">);
    made.store.link.value = { ...made.store.link.peek(), phase: live ? "live" : "stale" };
    made.store.help.value = true;
    return { ...made, eStop };
  }

  test("closes it, and leaves a standing robot unlatched", () => {
    const { eStop, press, store } = open();
    press("keydown", "Escape");
    expect(store.help.value).toBe(false);
    expect(eStop).not.toHaveBeenCalled();
    press("keydown", "Escape");
    expect(eStop).toHaveBeenCalledTimes(1);
  });

  test("closes what else is open over the page first, too", () => {
    const { eStop, press, store } = open();
    store.help.value = false;
    const older = vi.fn();
    const newer = vi.fn();
    store.opened(older);
    store.opened(newer);
    press("keydown", "Escape");
    expect(newer).toHaveBeenCalledTimes(1);
    expect(older).not.toHaveBeenCalled();
    press("keydown", "Escape"); // though the newer one is still to be drawn closed
    expect(newer).toHaveBeenCalledTimes(1);
    expect(older).toHaveBeenCalledTimes(1);
    expect(eStop).not.toHaveBeenCalled();
    press("keydown", "Escape");
    expect(eStop).toHaveBeenCalledTimes(1);
  });

  test("stops at once where what was open has closed by itself", () => {
    const { eStop, press, store } = open();
    store.help.value = false;
    const closed = store.opened(() => undefined);
    store.opened(() => undefined)();
    closed();
    closed();
    press("keydown", "Escape");
    expect(eStop).toHaveBeenCalledTimes(1);
  });

  test.each([
    ["moves", { state: "driving" }],
    ["has a place to go to", { going: true }],
    ["has not been heard of for a while", { live: false }],
  ])("stops a robot that %s", (_, robot) => {
    const { eStop, press, store } = open(robot);
    press("keydown", "Escape");
    expect(store.help.value).toBe(false);
    expect(eStop).toHaveBeenCalledTimes(1);
  });

  test("stops a robot that is just being set in motion", () => {
    const { eStop, press } = open();
    press("keydown", "KeyW");
    press("keydown", "Escape");
    expect(eStop).toHaveBeenCalledTimes(1);
  });
});

test("the keys for sideways drive only a body that can", () => {
  const { press, sent, store } = heldKeys();
  expect(press("keydown", "KeyQ")).toBe(false);
  expect(sent).toEqual([]);
  const robot = { limits: { lateral_mps: 0.3 } };
  store.hello.value = { drive: true, channels: {}, classes: [], robot } as unknown as typeof store.hello.value;
  expect(press("keydown", "KeyQ")).toBe(true);
  expect(sent.at(-1)).toMatchObject({ type: "drive", held: true, linear: 0, angular: 0 });
  expect((sent.at(-1) as { lateral?: number }).lateral).toBeGreaterThan(0);
});
