import { expect, test } from "vitest";
import { predicted, type Velocity } from "./prediction";
import examples from "./prediction.examples.json";
import { Predictor } from "./predictor";

const LIMITS = { linear_mps: 0.4, angular_radps: 1, lateral_mps: 0, linear_mps2: 0.8, angular_radps2: 2 };
const STILL = { linear: 0, angular: 0, lateral: 0 };
const velocityOf = ([linear, angular, lateral]: number[]): Velocity => ({
  linear: linear!,
  angular: angular!,
  lateral: lateral!,
});

test.each(examples)("$name: as the robot predicts it", (example) => {
  const [x, y, theta] = example.motion.pose as [number, number, number];
  const { stamp } = example.motion;
  const found = predicted(
    { stamp, x, y, theta, velocity: velocityOf(example.motion.velocity) },
    example.commands.map((each) => ({ stamp: each.stamp, velocity: velocityOf(each.velocity) })),
    example.until,
    example,
  );
  const { linear, angular } = found.velocity;
  [found.x, found.y, found.theta, linear, angular].forEach((value, i) =>
    expect(value).toBeCloseTo(example.predicted[i]!, 6),
  );
});

/** A robot that does what it is commanded `up` s later, to the `share` of the speed that a late link has, or not at all. */
function drive(obeys: boolean, share = 1, known = share): { worst: number; wrong: string } {
  const predictor = new Predictor();
  predictor.share = known;
  const up = 0.15;
  let robot = { stamp: 0, x: 0, y: 0, theta: 0, velocity: STILL };
  const commands = [
    { stamp: 0.5, velocity: obeys ? { linear: 0.4 * share, angular: 0.5 * share, lateral: 0 } : STILL },
  ];
  const expected: { at: number; x: number }[] = [];
  let worst = 0;
  for (let step = 0; step < 80; step++) {
    const stamp = 0.05 * step;
    robot = predicted(robot, commands, stamp, LIMITS);
    if (stamp >= 0.5 - up - 1e-9) predictor.command(stamp + up, { linear: 1, angular: 0.5, lateral: 0 }, LIMITS);
    predictor.measured(robot);
    const ahead = predictor.ahead(stamp + up, LIMITS);
    if (ahead) expected.push({ at: stamp + up, x: ahead.x });
    for (const { at, x } of expected) if (Math.abs(at - stamp) < 1e-9) worst = Math.max(worst, Math.abs(x - robot.x));
  }
  return { worst, wrong: predictor.wrong };
}

test("a robot that obeys is where it was expected", () => {
  const { worst, wrong } = drive(true);
  expect(worst).toBeLessThan(0.02);
  expect(wrong).toBe("");
});

test("a robot that is slowed for a late link is where it was expected, where the page knows by how much", () => {
  const [known, unknown] = [drive(true, 0.4).worst, drive(true, 0.4, 1).worst];
  expect(known).toBeLessThan(0.002);
  expect(unknown).toBeGreaterThan(4 * known);
});

test("a standing robot that nothing commands is nowhere else", () => {
  const predictor = new Predictor();
  predictor.measured({ stamp: 1, x: 2, y: 3, theta: 0, velocity: STILL });
  expect(predictor.ahead(1.3, LIMITS)).toBeNull();
});

test("an error is said when it is large and lasts", () => {
  const predictor = new Predictor();
  const at = (stamp: number, x: number) => ({ stamp, x, y: 0, theta: 0, velocity: { ...STILL, linear: 1 } });
  predictor.measured(at(0, 0));
  for (const stamp of [0.5, 1, 1.5]) {
    predictor.ahead(stamp, LIMITS);
    predictor.measured(at(stamp, 0));
  }
  expect(predictor.wrong).toBe("The robot is 0.5 m from where it was expected.");
  predictor.ahead(2, LIMITS);
  predictor.measured(at(2, 0.5));
  expect(predictor.wrong).toBe("");
});
