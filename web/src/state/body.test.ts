import { expect, test } from "vitest";
import type { DesireClass, Hello } from "../protocol/types";
import { bodyOf } from "./body";

const EVERYTHING = { camera: true, panorama: true, map: true, costmap: true, scan: true, point_cloud: true };
const kind = (name: string, served = true) => ({ name, served }) as DesireClass;
const hello = (some: Partial<Hello>) =>
  ({ drive: true, head: true, channels: EVERYTHING, classes: [], ...some }) as Hello;
const ALL = {
  drives: true,
  strafes: false,
  turnsHead: true,
  maps: true,
  goes: true,
  scans: true,
  places: true,
  faces: true,
  voices: true,
};

test("of a body that has not greeted, everything may be", () => {
  expect(bodyOf(null)).toEqual(ALL);
});

test("one that has it all can do it all", () => {
  const classes = [kind("GoTo"), kind("LocateFaces"), kind("LocateVoices")];
  expect(bodyOf(hello({ classes }))).toEqual(ALL);
});

test("a camera on a desk drives nowhere, maps nothing, and places nothing", () => {
  const classes = [kind("GoTo", false), kind("LocateFaces", true), kind("LocateVoices", false)];
  const channels = { ...EVERYTHING, map: false, scan: false, point_cloud: false };
  const nothing = {
    drives: false,
    strafes: false,
    turnsHead: false,
    maps: false,
    goes: false,
    scans: false,
    places: false,
    voices: false,
  };
  expect(bodyOf(hello({ drive: false, head: false, classes, channels }))).toEqual({ ...nothing, faces: true });
});

test("depth gives things a place without a laser", () => {
  const body = bodyOf(hello({ channels: { ...EVERYTHING, scan: false } }));
  expect([body.scans, body.places]).toEqual([false, true]);
});

test("a recording has faces and voices that no module looks for now", () => {
  const body = bodyOf(hello({ playback: {} as Hello["playback"] & {}, classes: [kind("LocateVoices", false)] }));
  expect([body.faces, body.voices]).toEqual([true, true]);
});

test("one whose limits have a sideways speed strafes", () => {
  const robot = (lateral_mps: number) => ({ limits: { lateral_mps } }) as Hello["robot"];
  expect(bodyOf(hello({ robot: robot(0.3) })).strafes).toBe(true);
  expect(bodyOf(hello({ robot: robot(0) })).strafes).toBe(false);
});
