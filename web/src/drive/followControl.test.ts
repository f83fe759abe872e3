import { expect, test, vi } from "vitest";
import { FollowControl, SILENT_MS, UNSEEN_MS } from "./followControl";
import { type Command, type DriveState, type Input, initialDrive, step } from "./machine";

/** The control before the machine that drives, and a clock by hand. */
function driven() {
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => {} });
  let state: DriveState = step(initialDrive(1), { type: "allow", allowed: true }).state;
  let sent: Command[] = [];
  const place = { now: 1000, focused: true };
  const input = (given: Input) => {
    const next = step(state, given);
    state = next.state;
    sent = [...sent, ...next.send];
  };
  const drive = { input, state: { peek: () => state } } as unknown as ConstructorParameters<typeof FollowControl>[0];
  const control = new FollowControl(
    drive,
    () => place.now,
    () => place.focused,
  );
  control.choose(2);
  const pass = (ms: number, bearing?: number) => {
    for (let passed = 0; passed < ms; passed += 50) {
      place.now += 50;
      if (bearing !== undefined) control.look({ bearing, gaze: 0 });
      control.beat();
    }
  };
  return { control, pass, input, place, last: () => sent.at(-1) ?? null, close: () => control.stop() };
}

test("nothing moves by itself, only while a hand has the view", () => {
  const { control, pass, last, close } = driven();
  pass(1000, 1.5);
  expect(last()).toBe(null);
  control.hand(true);
  pass(200, 1.5);
  expect(last()).toMatchObject({ held: true, head_held: true });
  expect(last()!.angular).toBeGreaterThan(0);
  control.hand(false);
  expect(last()).toMatchObject({ held: false, head_held: false, angular: 0, pan: 0 });
  close();
});

test("a frame that falls silent, or says no more where it looks, ends it", () => {
  const { control, pass, last, close } = driven();
  control.hand(true);
  pass(200, 1.5);
  pass(SILENT_MS + 100, 1.5);
  expect(last()).toMatchObject({ held: false, head_held: false });
  control.hand(true);
  pass(200, 1.5);
  expect(last()!.held).toBe(true);
  for (let passed = 0; passed <= UNSEEN_MS; passed += 100) {
    control.hand(true);
    pass(100);
  }
  expect(last()!.held).toBe(false);
  close();
});

test("directions that are none hold nothing on", () => {
  const { control, pass, last, close } = driven();
  control.hand(true);
  pass(100, Number.NaN);
  expect(last()).toMatchObject({ held: false, pan: 0 });
  control.hand(false);
  expect(last()!.head_held).toBe(false);
  close();
});

test("a page without the focus, Mode 1 and an emergency stop end it", () => {
  const { control, pass, input, place, last, close } = driven();
  const begin = () => {
    control.hand(true);
    pass(150, 1.5);
    expect(last()!.held).toBe(true);
  };
  begin();
  place.focused = false;
  pass(50, 1.5);
  expect(last()!.held).toBe(false);
  place.focused = true;
  begin();
  input({ type: "allow", allowed: false });
  expect(last()!.held).toBe(false);
  pass(100, 1.5);
  expect(last()!.held).toBe(false);
  input({ type: "allow", allowed: true });
  begin();
  control.choose(1);
  expect(last()).toMatchObject({ held: false, head_held: false });
  close();
});

test("what is drawn of the soft limit says when the head is past it, and is nothing in Mode 1", () => {
  const { control, close } = driven();
  control.setLimit(30);
  control.look({ bearing: 0, gaze: 0.5 });
  expect(control.softLimit.value).toEqual({ angle: Math.PI / 6, past: false });
  control.look({ bearing: 0, gaze: -0.6 });
  expect(control.softLimit.value).toEqual({ angle: Math.PI / 6, past: true });
  control.choose(1);
  expect(control.softLimit.value).toBe(null);
  close();
});

test("a hand that drives turns by itself; where it does not, the base follows the view", () => {
  const { pass, input, last, close } = driven();
  input({ type: "key", code: "KeyW", down: true });
  pass(200, 1.5);
  expect(last()).toMatchObject({ linear: 1, head_held: true });
  expect(last()!.angular).toBeGreaterThan(0);
  input({ type: "key", code: "KeyD", down: true });
  expect(last()!.angular).toBe(-1);
  input({ type: "key", code: "KeyD", down: false });
  input({ type: "key", code: "KeyW", down: false });
  pass(50, 1.5);
  expect(last()).toMatchObject({ held: false, head_held: false });
  close();
});
