import { describe, expect, it } from "vitest";
import { blended, CALM, JOINTS, type Pose, poseOf, same, shapesOf } from "./shape";

const HAPPY: Pose = { ...CALM, left_mouth_corner_joint: 0.68, right_mouth_corner_joint: 0.68, lower_lip_joint: 0.2 };

/** The numbers of a path, as points. */
function points(path: string): [number, number][] {
  const numbers = path.match(/-?[\d.]+/g)!.map(Number);
  return numbers.flatMap((x, place) => (place % 2 === 0 ? [[x, numbers[place + 1]!] as [number, number]] : []));
}

describe("shapesOf", () => {
  it("is symmetric in a calm face", () => {
    const { left, right, mouth } = shapesOf(CALM);
    const placesOf = (path: string, mirror: boolean) =>
      new Set(points(path).map(([x, y]) => `${(mirror ? 1000 - x : x).toFixed(1)} ${y}`));
    expect(placesOf(left.outline, false)).toEqual(placesOf(right.outline, true));
    expect(placesOf(left.brow, false)).toEqual(placesOf(right.brow, true));
    const corners = points(mouth);
    expect(corners[0]![1]).toBe(corners[3]![1]);
    expect(corners[0]![0] + corners[3]![0]).toBeCloseTo(1000);
  });

  it("shows the robot's left on the right, as it stands opposite", () => {
    expect(points(shapesOf({ ...CALM, left_mouth_corner_joint: 0.7 }).mouth)[3]![1]).toBeLessThan(
      points(shapesOf(CALM).mouth)[3]![1],
    );
    expect(shapesOf({ ...CALM, eyes_pan_joint: 0.4 }).left.iris.x).toBeGreaterThan(shapesOf(CALM).left.iris.x);
    expect(shapesOf({ ...CALM, eyes_tilt_joint: 0.3 }).right.iris.y).toBeLessThan(shapesOf(CALM).right.iris.y);
  });

  it("closes the eyes to a line", () => {
    const heights = (lids: number) => {
      const ys = points(shapesOf({ ...CALM, eyelids_joint: lids }).left.outline).map(([, y]) => y);
      return Math.max(...ys) - Math.min(...ys);
    };
    expect(heights(0)).toBeGreaterThan(200);
    expect(heights(1.2)).toBeLessThan(40);
    expect(heights(9)).toBe(heights(1.2));
  });

  it("raises the inner ends of the brows", () => {
    const [outer, inner] = [0, 2];
    const calm = points(shapesOf(CALM).left.brow);
    const raised = points(shapesOf({ ...CALM, left_eyebrow_joint: 0.5 }).left.brow);
    expect(raised[inner]![1] - raised[outer]![1]).toBeLessThan(calm[inner]![1] - calm[outer]![1]);
    expect(raised[inner]![0]).toBeLessThan(raised[outer]![0]);
  });

  it("opens the mouth, and never turns it inside out", () => {
    const opened = (upper: number, lower: number) => {
      const [, high, , , low] = points(shapesOf({ ...CALM, upper_lip_joint: upper, lower_lip_joint: lower }).mouth);
      return low![1] - high![1];
    };
    expect(opened(0.1, 0.38)).toBeGreaterThan(opened(0.02, 0.03) + 80);
    expect(opened(-0.1, -0.1)).toBeGreaterThanOrEqual(0);
  });

  it("has rosy cheeks when it smiles alone", () => {
    expect(shapesOf(CALM).cheeks).toBe(0);
    expect(shapesOf(HAPPY).cheeks).toBe(1);
  });
});

describe("blended", () => {
  it("is there within a tenth of a second, whatever the frames", () => {
    let shown = CALM;
    for (let frame = 0; frame < 10; frame += 1) shown = blended(shown, HAPPY, 0.01);
    const once = blended(CALM, HAPPY, 0.1);
    for (const joint of JOINTS) expect(shown[joint]).toBeCloseTo(once[joint], 6);
    expect(once.left_mouth_corner_joint).toBeGreaterThan(0.66);
    expect(same(blended(CALM, HAPPY, 10), HAPPY)).toBe(true);
  });

  it("stands where no time passes, also for a clock that goes back", () => {
    expect(blended(CALM, HAPPY, 0)).toEqual(CALM);
    expect(blended(CALM, HAPPY, -1)).toEqual(CALM);
  });
});

describe("poseOf", () => {
  it("takes the nine joints, and leaves calm what the body does not have", () => {
    expect(poseOf({ lower_lip_joint: 0.3, tail_joint: 1 })).toEqual({ ...CALM, lower_lip_joint: 0.3 });
  });
});
