import { expect, test } from "vitest";
import type { HeardSound, Perceived, SeenFace } from "../protocol/types";
import { directionWords, FADE_S, faceMarks, flash, soundMarks, summary } from "./perceptMarks";

const nowhere = {
  azimuth: 0,
  elevation: 0,
  panorama: null,
  range_m: null,
  range_sigma_m: null,
  x: null,
  y: null,
  z: null,
};
const face = (some: Partial<SeenFace>): SeenFace => ({
  ...nowhere,
  towards_O: null,
  track: 1,
  stamp: 10,
  camera: "kinect_optical_frame",
  score: 0.9,
  box: [0, 0, 10, 10],
  image: [640, 480],
  ...some,
});
const sound = (some: Partial<HeardSound>): HeardSound => ({
  ...nowhere,
  p_OA: null,
  v_O: null,
  track: 1,
  stamp: 10,
  power: 0.5,
  level_db: -40,
  active: true,
  last_active: 10,
  speech: 0.9,
  ...some,
});
const perceived = (some: Partial<Perceived>): Perceived => ({
  stamp: 10,
  faces: [],
  sounds: [],
  noises: [],
  codes: [],
  ...some,
});

test("a person that both cameras see is one, at the better known distance", () => {
  const marks = faceMarks(
    perceived({
      faces: [
        face({ camera: "panorama_optical_frame", range_m: 2, range_sigma_m: 0.5 }),
        face({ range_m: 1.8, range_sigma_m: 0.02 }),
      ],
    }),
  );
  expect(marks.map(({ text }) => text)).toEqual(["Person 1, 1.8 m"]);
});

test("marks lie where the panorama has them, else where their own sensor has them", () => {
  const marks = faceMarks(
    perceived({ faces: [face({ azimuth: 0.2, panorama: [0.3, 0.1] }), face({ track: 2, azimuth: 0.2 })] }),
  );
  expect(marks.map(({ azimuth }) => azimuth)).toEqual([0.3, 0.2]);
});

test("the nearer lies over the farther, and is larger", () => {
  const [far, near] = faceMarks(perceived({ faces: [face({ range_m: 1 }), face({ track: 2, range_m: 4 })] }));
  expect([far!.track, near!.track]).toEqual([2, 1]);
  expect(near!.width).toBeGreaterThan(3 * far!.width);
});

test("a sound that fell silent fades and is gone", () => {
  const message = perceived({ sounds: [sound({ active: false, last_active: 10 })] });
  expect(soundMarks(message, 10)[0]!.opacity).toBeCloseTo(1);
  expect(soundMarks(message, 10 + FADE_S / 2)[0]!.opacity).toBeCloseTo(0.5);
  expect(soundMarks(message, 10 + FADE_S)).toEqual([]);
  expect(soundMarks(perceived({ sounds: [sound({ last_active: 1 })] }), 10)[0]!.opacity).toBe(1);
});

test("the louder is larger; a sound without a judgement is neither voice nor other sound", () => {
  const marks = soundMarks(
    perceived({ sounds: [sound({ level_db: -20, speech: null }), sound({ track: 2, level_db: -60, speech: 0.1 })] }),
    10,
  );
  expect(marks.map(({ kind }) => kind)).toEqual(["sound", "unjudged"]);
  expect(marks[1]!.loudness).toBeGreaterThan(marks[0]!.loudness);
});

test("a noise flashes and is over", () => {
  const message = perceived({ noises: [{ stamp: 10, ratio: 30, level_db: -20 }] });
  expect(flash(message, 10)).toBe(1);
  expect(flash(message, 10.35)).toBeCloseTo(0.5);
  expect(flash(message, 11)).toBe(0);
  expect(flash(null, 11)).toBe(0);
});

test.each([
  [0, "ahead"],
  [0.52, "30° left"],
  [-1.57, "90° right"],
  [3.1, "behind"],
])("%d is %s", (azimuth, words) => expect(directionWords(azimuth)).toBe(words));

test("in words", () => {
  const faces = faceMarks(perceived({ faces: [face({}), face({ track: 2 })] }));
  const sounds = soundMarks(perceived({ sounds: [sound({ azimuth: 0.52 }), sound({ track: 2, active: false })] }), 10);
  expect(summary(faces, sounds, false)).toBe("2 people, 1 voice at 30° left");
  expect(summary(faces.slice(1), [], true)).toBe("1 person ahead, a loud noise");
  expect(summary([], [], false)).toBe("");
});
