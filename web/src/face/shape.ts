/** The face as shapes, from the positions of its nine joints. Pure; units of the picture, y down, the robot's left on the
 * right. */

/** Positions (rad) of the face's joints: eyebrows' inner ends up, eyes left and up, eyelids closed, corners of the mouth up,
 * lips open. */
export interface Pose {
  left_eyebrow_joint: number;
  right_eyebrow_joint: number;
  eyes_pan_joint: number;
  eyes_tilt_joint: number;
  eyelids_joint: number;
  left_mouth_corner_joint: number;
  right_mouth_corner_joint: number;
  upper_lip_joint: number;
  lower_lip_joint: number;
}

/** What is shown while nothing is known of the robot. */
export const CALM: Pose = {
  left_eyebrow_joint: 0.12,
  right_eyebrow_joint: 0.12,
  eyes_pan_joint: 0,
  eyes_tilt_joint: 0,
  eyelids_joint: 0.26,
  left_mouth_corner_joint: 0.18,
  right_mouth_corner_joint: 0.18,
  upper_lip_joint: 0.02,
  lower_lip_joint: 0.03,
};
export const JOINTS = Object.keys(CALM) as (keyof Pose)[];

export interface Point {
  x: number;
  y: number;
}

export interface Eye {
  /** The outline of what is open of it, and the edge of its upper lid, thickest in the middle. */
  outline: string;
  lid: string;
  iris: Point;
  brow: string;
}

export interface Shapes {
  left: Eye;
  right: Eye;
  /** The outline of the lips, and the tongue behind them. */
  mouth: string;
  tongue: Point;
  /** How rosy the cheeks are, 0 to 1. */
  cheeks: number;
}

/** Position of the open eyes' middle beside the face's, and their half axes. */
const EYE = { beside: 165, y: 270, rx: 96, ry: 108, lid: 20 };
const LIDS_CLOSED = 1.2;
const BROW = { above: 36, half: 84, bow: 24, lift: 70, turn: 0.8 };
const MOUTH = { x: 500, y: 490, half: 128, corner: 96, wide: 50, upper: 150, lower: 215 };
/** A smile raises the lower lids by this share of the eye's height. */
const SMILE = 0.34;
/** A cubic curve's middle lies at three quarters of the way to its control points. */
const FULL = 4 / 3;

export function shapesOf(pose: Pose): Shapes {
  const closed = clamp(pose.eyelids_joint / LIDS_CLOSED, 0, 1);
  const smile = clamp((pose.left_mouth_corner_joint + pose.right_mouth_corner_joint - 0.4) / 0.9, 0, 1);
  const gaze = { x: 62 * Math.sin(pose.eyes_pan_joint), y: -62 * Math.sin(pose.eyes_tilt_joint) };
  return {
    left: eye(1, { closed, smile, gaze, brow: pose.left_eyebrow_joint }),
    right: eye(-1, { closed, smile, gaze, brow: pose.right_eyebrow_joint }),
    ...mouth(pose),
    cheeks: smile,
  };
}

/** `side`: 1 on the right of the picture, -1 on its left. */
function eye(side: number, of: { closed: number; smile: number; gaze: Point; brow: number }): Eye {
  const { closed, gaze } = of;
  const x = 500 + side * EYE.beside;
  const corner = EYE.y + 0.34 * EYE.ry * closed;
  const upper = corner + FULL * (mix(EYE.y - EYE.ry, EYE.y + 0.52 * EYE.ry, closed) - corner);
  const lower = corner + FULL * (mix(EYE.y + EYE.ry * (1 - SMILE * of.smile), EYE.y + 0.56 * EYE.ry, closed) - corner);
  const [begin, end] = [x - EYE.rx, x + EYE.rx];
  const edge = `M${n(begin)} ${n(corner)}C${n(begin)} ${n(upper)} ${n(end)} ${n(upper)} ${n(end)} ${n(corner)}`;
  const above = upper - EYE.lid;
  return {
    outline: `${edge}C${n(end)} ${n(lower)} ${n(begin)} ${n(lower)} ${n(begin)} ${n(corner)}Z`,
    lid: `${edge}C${n(end)} ${n(above)} ${n(begin)} ${n(above)} ${n(begin)} ${n(corner)}Z`,
    iris: { x: x + gaze.x, y: EYE.y + 8 + gaze.y + 10 * closed },
    brow: eyebrow(side, x, of.brow),
  };
}

function eyebrow(side: number, x: number, position: number): string {
  const middle = EYE.y - EYE.ry - BROW.above - BROW.lift * position;
  const [along, across] = [Math.cos(BROW.turn * position), Math.sin(BROW.turn * position)];
  const at = (inward: number, up: number) =>
    `${n(x - side * (inward * along + up * across))} ${n(middle - inward * across - up * along)}`;
  return `M${at(-BROW.half, -8)}Q${at(-0.1 * BROW.half, BROW.bow)} ${at(BROW.half, 0)}`;
}

function mouth(pose: Pose): Pick<Shapes, "mouth" | "tongue"> {
  const [left, right] = [pose.left_mouth_corner_joint, pose.right_mouth_corner_joint];
  const half = (corner: number) => MOUTH.half + MOUTH.wide * (corner > 0 ? corner : 0.5 * corner);
  const a = { x: MOUTH.x - half(right), y: MOUTH.y - MOUTH.corner * Math.sin(right) };
  const b = { x: MOUTH.x + half(left), y: MOUTH.y - MOUTH.corner * Math.sin(left) };
  const base = MOUTH.y + 0.28 * MOUTH.corner * Math.sin((left + right) / 2);
  const upper = base - MOUTH.upper * Math.max(pose.upper_lip_joint, -0.02);
  const lower = Math.max(base + MOUTH.lower * pose.lower_lip_joint, upper);
  const corners = (a.y + b.y) / 2;
  const [high, low] = [upper, lower].map((y) => corners + FULL * (y - corners)) as [number, number];
  // Controls lie inside the corners, so that these stay pointed.
  const [c, d] = [mix(a.x, b.x, 0.22), mix(a.x, b.x, 0.78)];
  return {
    mouth:
      `M${n(a.x)} ${n(a.y)}C${n(c)} ${n(high)} ${n(d)} ${n(high)} ${n(b.x)} ${n(b.y)}` +
      `C${n(d)} ${n(low)} ${n(c)} ${n(low)} ${n(a.x)} ${n(a.y)}Z`,
    tongue: { x: (a.x + b.x) / 2, y: lower + 22 },
  };
}

/** Between what is shown and what is to be, after `elapsedS`: within about a tenth of a second it is there. */
export function blended(shown: Pose, target: Pose, elapsedS: number): Pose {
  const share = 1 - Math.exp(-Math.max(elapsedS, 0) / BLEND_S);
  const next = { ...shown };
  for (const joint of JOINTS) next[joint] = mix(shown[joint], target[joint], share);
  return next;
}
const BLEND_S = 0.03;

/** The pose of a message's joints; those that the body does not have stay calm. */
export function poseOf(joints: Readonly<Record<string, number>>): Pose {
  const pose = { ...CALM };
  for (const joint of JOINTS) pose[joint] = joints[joint] ?? CALM[joint];
  return pose;
}

/** Whether two poses look the same. */
export function same(a: Pose, b: Pose): boolean {
  return JOINTS.every((joint) => Math.abs(a[joint] - b[joint]) < 5e-4);
}

function mix(a: number, b: number, share: number): number {
  return a + share * (b - a);
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}

function n(value: number): string {
  return value.toFixed(1);
}
