import { describe, expect, test } from "vitest";
import { type Command, type DriveState, flush, type Input, initialDrive, step } from "./machine";

const down = (code: string, repeat = false): Input => ({ type: "key", code, down: true, repeat });
const up = (code: string): Input => ({ type: "key", code, down: false });
const tick: Input = { type: "tick" };

function run(inputs: Input[], start: DriveState = ready()): { state: DriveState; sent: Command[] } {
  let state = start;
  const sent: Command[] = [];
  for (const input of inputs) {
    const next = step(state, input);
    state = next.state;
    sent.push(...next.send);
  }
  return { state, sent };
}

function ready(factor = 1): DriveState {
  return step(initialDrive(factor), { type: "allow", allowed: true }).state;
}

const brief = (commands: Command[]) => commands.map((c) => [c.held, c.linear, c.angular]);

describe("keyboard", () => {
  test("a held key drives at once, repeats each tick, and a release is said three times, then silence", () => {
    const { sent } = run([down("KeyW"), tick, tick, up("KeyW"), tick, tick, tick, tick]);
    expect(brief(sent)).toEqual([
      [true, 1, 0],
      [true, 1, 0],
      [true, 1, 0],
      [false, 0, 0],
      [false, 0, 0],
      [false, 0, 0],
    ]);
    expect(sent.map((c) => c.seq)).toEqual([1, 2, 3, 4, 5, 6]);
  });

  test("keys combine, arrows are the same keys, opposite keys cancel but hold", () => {
    expect(brief(run([down("KeyW"), down("ArrowLeft")]).sent)).toEqual([
      [true, 1, 0],
      [true, 1, 1],
    ]);
    expect(brief(run([down("KeyW"), down("KeyS")]).sent).at(-1)).toEqual([true, 0, 0]);
    expect(brief(run([down("KeyS"), down("KeyD")]).sent).at(-1)).toEqual([true, -1, -1]);
  });

  test("keys for sideways hold like the others, and combine with them", () => {
    const { sent } = run([down("KeyQ"), down("KeyW"), up("KeyQ"), down("KeyE"), down("ShiftLeft")]);
    expect(sent.map((c) => [c.held, c.linear, c.lateral])).toEqual([
      [true, 0, 1],
      [true, 1, 1],
      [true, 1, 0],
      [true, 1, -1],
      [true, 0.4, -0.4],
    ]);
  });

  test("auto-repeat says nothing new, and does not restart after a release", () => {
    const { sent, state } = run([
      down("KeyW"),
      down("KeyW", true),
      { type: "release" },
      down("KeyW", true),
      tick,
      tick,
      tick,
    ]);
    expect(brief(sent)).toEqual([
      [true, 1, 0],
      [false, 0, 0],
      [false, 0, 0],
      [false, 0, 0],
    ]);
    expect(brief(run([up("KeyW"), down("KeyW")], state).sent)).toEqual([[true, 1, 0]]);
  });

  test("shift slows, presets scale, and other keys are nothing", () => {
    expect(brief(run([down("ShiftLeft"), down("KeyW"), up("ShiftLeft")]).sent)).toEqual([
      [true, 0.4, 0],
      [true, 1, 0],
    ]);
    expect(brief(run([{ type: "preset", factor: 0.3 }, down("KeyW"), down("ShiftLeft")]).sent)).toEqual([
      [true, 0.3, 0],
    ]);
    expect(run([down("KeyZ"), down("ShiftLeft"), tick]).sent).toEqual([]);
  });
});

describe("what is not allowed does not drive", () => {
  test("nothing moves before it is allowed, and a key held meanwhile must be pressed again", () => {
    const { sent, state } = run(
      [down("KeyW"), tick, { type: "allow", allowed: true }, down("KeyW", true), tick],
      initialDrive(1),
    );
    expect(sent).toEqual([]);
    expect(brief(run([up("KeyW"), down("KeyW")], state).sent)).toEqual([[true, 1, 0]]);
  });

  test("losing the permission releases everything", () => {
    const { sent, state } = run([down("KeyW"), { type: "allow", allowed: false }]);
    expect(brief(sent).at(-1)).toEqual([false, 0, 0]);
    expect(state.keys.size).toBe(0);
  });
});

describe("stick", () => {
  const start: Input = { type: "stick-start", axes: { linear: 0.5, angular: -0.2, lateral: 0 } };

  test("is clamped, and a centred stick under a finger still holds", () => {
    const { sent } = run([
      start,
      { type: "stick-move", axes: { linear: 3, angular: -7, lateral: 0 } },
      { type: "stick-move", axes: { linear: 0, angular: 0, lateral: 0 } },
    ]);
    expect(brief(sent)).toEqual([
      [true, 0.5, -0.2],
      [true, 1, -1],
      [true, 0, 0],
    ]);
  });

  test("moves after a lost pointer are ignored until it is grasped again", () => {
    const { sent } = run([
      start,
      { type: "release" },
      { type: "stick-move", axes: { linear: 1, angular: 0, lateral: 0 } },
    ]);
    expect(brief(sent)).toEqual([
      [true, 0.5, -0.2],
      [false, 0, 0],
    ]);
  });

  test("the hand that holds keeps the wheel until it lets go", () => {
    const { sent, state } = run([start, down("KeyW"), { type: "stick-end" }]);
    expect(brief(sent)).toEqual([
      [true, 0.5, -0.2],
      [true, 1, 0],
    ]);
    expect(state.source).toBe("keyboard");
  });

  test("numbers that are none stop", () => {
    expect(brief(run([{ type: "stick-start", axes: { linear: NaN, angular: Infinity, lateral: 0 } }]).sent)).toEqual([
      [true, 0, 0],
    ]);
  });
});

describe("gamepad", () => {
  const pad = (linear: number): Input => ({ type: "pad", axes: { linear, angular: 0, lateral: 0 } });
  const let_go: Input = { type: "pad", axes: null };

  test("drives only while its dead-man is held", () => {
    expect(brief(run([let_go, pad(0.5), pad(0.5), let_go]).sent)).toEqual([
      [true, 0.5, 0],
      [false, 0, 0],
    ]);
  });

  test("a dead-man held through a release is spent", () => {
    const { sent } = run([pad(0.5), { type: "release" }, pad(0.5), pad(0.7), let_go, pad(0.7)]);
    expect(brief(sent)).toEqual([
      [true, 0.5, 0],
      [false, 0, 0],
      [true, 0.7, 0],
    ]);
  });

  test("a dead-man held since before driving was allowed is spent", () => {
    const { sent } = run([pad(1), { type: "allow", allowed: true }, pad(1), let_go, pad(1)], initialDrive(1));
    expect(brief(sent)).toEqual([[true, 1, 0]]);
  });
});

describe("override", () => {
  const hold: Input = { type: "override", held: true };
  const drop: Input = { type: "override", held: false };
  const said = (inputs: Input[], start?: DriveState) => run(inputs, start).sent.map((c) => [c.held, c.override]);

  test("by itself does nothing; with the dead-man it is said at once, each tick, and when it ends", () => {
    expect(said([hold, tick, drop, down("KeyO"), tick])).toEqual([]);
    expect(said([down("KeyW"), hold, tick, drop, tick])).toEqual([
      [true, false],
      [true, true],
      [true, true],
      [true, false],
      [true, false],
    ]);
  });

  test("a key, a trigger and the button on screen are the same, whichever hand drives", () => {
    const stick: Input = { type: "stick-start", axes: { linear: 1, angular: 0, lateral: 0 } };
    expect(said([stick, down("KeyO")]).at(-1)).toEqual([true, true]);
    expect(said([down("KeyO"), down("KeyW")])).toEqual([[true, true]]);
    const pad: Input = { type: "pad", axes: { linear: 1, angular: 0, lateral: 0 }, override: true };
    expect(said([pad])).toEqual([[true, true]]);
    expect(said([pad, { ...pad, override: false }])).toEqual([
      [true, true],
      [true, false],
    ]);
  });

  test("letting go of the dead-man says neither", () => {
    expect(said([hold, down("KeyW"), up("KeyW"), tick])).toEqual([
      [true, true],
      [false, false],
      [false, false],
    ]);
  });

  test("a release ends it: it must be pressed again", () => {
    const { state } = run([hold, down("KeyO"), down("KeyW"), { type: "release" }]);
    expect(said([down("KeyO", true), down("KeyW")], state)).toEqual([[true, false]]);
    const pad: Input = { type: "pad", axes: { linear: 1, angular: 0, lateral: 0 }, override: true };
    const after = run([pad, { type: "release" }, pad, down("KeyW")]);
    expect(after.sent.map((c) => c.override)).toEqual([true, false, false]);
  });

  test("it is not held before driving is allowed", () => {
    const { sent } = run([hold, { type: "allow", allowed: true }, down("KeyW")], initialDrive(1));
    expect(sent.map((c) => c.override)).toEqual([false]);
  });
});

describe("head", () => {
  const head = (commands: Command[]) => commands.map((c) => [c.held, c.head_held, c.pan, c.tilt]);
  const start: Input = { type: "head-start", axes: { pan: 0.5, tilt: -2 } };

  test("its keys turn it alone, repeat each tick, and a release is said three times", () => {
    expect(head(run([down("KeyJ"), down("KeyI"), tick, up("KeyJ"), up("KeyI"), tick, tick, tick]).sent)).toEqual([
      [false, true, 1, 0],
      [false, true, 1, 1],
      [false, true, 1, 1],
      [false, true, 0, 1],
      [false, false, 0, 0],
      [false, false, 0, 0],
      [false, false, 0, 0],
    ]);
  });

  test("it is turned while the base is driven, and each hold ends by itself", () => {
    const { sent } = run([down("KeyW"), start, up("KeyW"), { type: "head-end" }]);
    expect(head(sent)).toEqual([
      [true, false, 0, 0],
      [true, true, 0.5, -1],
      [false, true, 0.5, -1],
      [false, false, 0, 0],
    ]);
    expect(sent[2]!.linear).toBe(0);
  });

  test("the speed preset and shift are its, too", () => {
    expect(head(run([{ type: "preset", factor: 0.5 }, down("KeyL"), down("ShiftLeft")]).sent)).toEqual([
      [false, true, -0.5, 0],
      [false, true, -0.4, 0],
    ]);
  });

  test("a release lets go of it until it is grasped again, and before it is allowed it stays", () => {
    const { sent, state } = run([start, { type: "release" }, { type: "head-move", axes: { pan: 1, tilt: 0 } }]);
    expect(head(sent)).toEqual([
      [false, true, 0.5, -1],
      [false, false, 0, 0],
    ]);
    expect(state.headStick).toBeNull();
    expect(run([start, down("KeyJ")], initialDrive(1)).sent).toEqual([]);
  });
});

test("flush says every release still owed at once", () => {
  const { state } = run([down("KeyW"), { type: "release" }]);
  const { send, state: after } = flush(state);
  expect(brief(send)).toEqual([
    [false, 0, 0],
    [false, 0, 0],
  ]);
  expect(step(after, tick).send).toEqual([]);
});

test("whatever is pressed and lost: a release always ends in not held, with sequence numbers that grow by one", () => {
  const inputs: Input[] = [
    down("KeyW"),
    up("KeyW"),
    down("KeyA"),
    down("ShiftLeft"),
    { type: "stick-start", axes: { linear: 1, angular: 0, lateral: 0 } },
    { type: "stick-move", axes: { linear: 0.2, angular: 1, lateral: 0 } },
    { type: "stick-end" },
    { type: "pad", axes: { linear: 1, angular: 1, lateral: 0 } },
    { type: "pad", axes: null },
    { type: "override", held: true },
    { type: "head-start", axes: { pan: 1, tilt: -1 } },
    { type: "head-end" },
    down("KeyJ"),
    down("KeyO"),
    { type: "allow", allowed: false },
    { type: "allow", allowed: true },
    tick,
    { type: "preset", factor: 0.5 },
  ];
  let seed = 7;
  const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
  for (let round = 0; round < 200; round++) {
    const chosen = Array.from({ length: 30 }, () => inputs[Math.floor(random() * inputs.length)]!);
    const { state, sent } = run([...chosen, { type: "release" }]);
    expect(state.command.held).toBe(false);
    expect(state.command.head_held).toBe(false);
    expect(sent.every((command) => command.held || !command.override)).toBe(true);
    expect(state.source).toBeNull();
    sent.forEach((command, i) => expect(command.seq).toBe(i + 1));
  }
});
