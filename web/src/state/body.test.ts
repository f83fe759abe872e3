import { expect, test } from "vitest";
import type { DesireClass, Hello } from "../protocol/types";
import { bodyOf } from "./body";

const kind = (name: string, served?: boolean) => ({ name, ...(served === undefined ? {} : { served }) }) as DesireClass;
const hello = (some: Partial<Hello>) => ({ channels: {}, classes: [], ...some }) as unknown as Hello;
const ALL = { drives: true, maps: true, goes: true, scans: true, places: true, faces: true, voices: true };

test("of a body that has not greeted, everything may be", () => {
  expect(bodyOf(null)).toEqual(ALL);
});

test("older programs do not tell what they lack", () => {
  const classes = [kind("GoTo"), kind("LocateFaces"), kind("LocateVoices")];
  expect(bodyOf(hello({ classes, channels: { map: true } }))).toEqual(ALL);
});

test("a camera on a desk drives nowhere, maps nothing, and places nothing", () => {
  const classes = [kind("GoTo", false), kind("LocateFaces", true), kind("LocateVoices", false)];
  const channels = { camera: true, map: false, scan: false, point_cloud: false };
  const nothing = { drives: false, maps: false, goes: false, scans: false, places: false, voices: false };
  expect(bodyOf(hello({ drive: false, classes, channels }))).toEqual({ ...nothing, faces: true });
});

test("depth gives things a place without a laser", () => {
  const body = bodyOf(hello({ channels: { scan: false, point_cloud: true } }));
  expect([body.scans, body.places]).toEqual([false, true]);
});

test("a recording has faces and voices that nobody looks for now", () => {
  const body = bodyOf(hello({ playback: {} as Hello["playback"] & {}, classes: [kind("LocateVoices", false)] }));
  expect([body.faces, body.voices]).toEqual([true, true]);
});
