import { expect, test } from "vitest";
import { type Hands, handsOf, pass, restyled, STEP_MS, type Style } from "./driveStyle";
import { type DriveState, type Input, initialDrive, step, TICK_MS } from "./machine";

/** Hands and machine together, as the page joins them. */
function driver(style: Style) {
  let hands: Hands = handsOf(style);
  let state: DriveState = step(initialDrive(1), { type: "allow", allowed: true }).state;
  const give = (inputs: Input[]) => {
    for (const each of inputs) state = step(state, each).state;
  };
  return {
    input(input: Input) {
      const passed = pass(hands, input);
      hands = passed.hands;
      give(passed.inputs);
    },
    restyle(to: Style) {
      const passed = restyled(hands, to);
      hands = passed.hands;
      give(passed.inputs);
    },
    key(code: string, down = true, repeat = false) {
      this.input({ type: "key", code, down, repeat });
    },
    ticks(count: number) {
      for (let n = 0; n < count; n++) this.input({ type: "tick" });
    },
    get command() {
      return state.command;
    },
  };
}

const STEP_TICKS = STEP_MS / TICK_MS;

test("held, a key drives until it is let go of", () => {
  const it = driver("hold");
  it.key("KeyW");
  it.ticks(100);
  expect(it.command).toMatchObject({ held: true, linear: 1 });
  it.key("KeyW", false);
  expect(it.command.held).toBe(false);
});

test("a step ends by itself, however long the key stays down, and not before", () => {
  const it = driver("step");
  it.key("KeyW");
  it.key("KeyW", false);
  it.ticks(STEP_TICKS - 1);
  expect(it.command.held).toBe(true);
  it.ticks(1);
  expect(it.command.held).toBe(false);
  it.key("KeyW");
  it.ticks(STEP_TICKS);
  it.key("KeyW", true, true);
  expect(it.command.held).toBe(false);
});

test("a press during a step prolongs it by one, in both directions together", () => {
  const it = driver("step");
  it.key("KeyW");
  it.ticks(STEP_TICKS / 2);
  it.key("KeyA");
  expect(it.command).toMatchObject({ linear: 1, angular: 1 });
  it.ticks(STEP_TICKS - 1);
  expect(it.command.held).toBe(true);
  it.ticks(1);
  expect(it.command.held).toBe(false);
});

test("one press goes, and any next stops", () => {
  for (const next of ["KeyW", "KeyD"]) {
    const it = driver("click");
    it.key("KeyW");
    it.key("KeyW", false);
    it.ticks(50);
    expect(it.command.held).toBe(true);
    it.key(next);
    expect(it.command.held).toBe(false);
    it.key(next, false);
    it.ticks(5);
    expect(it.command.held).toBe(false);
  }
});

test("one press of the stick goes where it points, and the next stops without steering", () => {
  const it = driver("click");
  const axes = (linear: number) => ({ linear, angular: 0, lateral: 0 });
  it.input({ type: "stick-start", axes: axes(0.2) });
  it.input({ type: "stick-move", axes: axes(0.6) });
  it.input({ type: "stick-end" });
  it.ticks(20);
  expect(it.command).toMatchObject({ held: true, linear: 0.6 });
  it.input({ type: "stick-start", axes: axes(1) });
  expect(it.command.held).toBe(false);
  it.input({ type: "stick-move", axes: axes(1) });
  it.input({ type: "stick-end" });
  expect(it.command.held).toBe(false);
});

test.each(["step", "click"] as const)("a %s ends with a release, a refusal and another style", (style) => {
  for (const end of [
    (it: ReturnType<typeof driver>) => it.input({ type: "release" }),
    (it: ReturnType<typeof driver>) => it.input({ type: "allow", allowed: false }),
    (it: ReturnType<typeof driver>) => it.restyle("hold"),
  ]) {
    const it = driver(style);
    it.key("KeyW");
    expect(it.command.held).toBe(true);
    end(it);
    expect(it.command.held).toBe(false);
    it.ticks(STEP_TICKS);
    expect(it.command.held).toBe(false);
  }
});

test("in any order of presses, a step is never longer than its time after the last press", () => {
  const codes = ["KeyW", "KeyS", "KeyA", "ArrowUp"];
  let seed = 7;
  const random = (below: number) => {
    seed = (seed * 1103515245 + 12345) % 2147483648;
    return seed % below;
  };
  for (let round = 0; round < 200; round++) {
    const it = driver("step");
    for (let n = 0; n < 20; n++) {
      const kind = random(3);
      if (kind === 0) it.key(codes[random(codes.length)]!);
      else if (kind === 1) it.key(codes[random(codes.length)]!, false);
      else it.ticks(random(STEP_TICKS));
    }
    it.ticks(STEP_TICKS);
    expect(it.command.held).toBe(false);
  }
});

test("the head is held in each style", () => {
  const it = driver("click");
  it.key("KeyJ");
  expect(it.command.head_held).toBe(true);
  it.key("KeyJ", false);
  expect(it.command.head_held).toBe(false);
});
