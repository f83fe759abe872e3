import { expect, test } from "vitest";
import type { Perceived, SeenFace } from "../protocol/types";
import { codesOn, facesOn } from "./faces";

const face = (camera: string, stamp: number) => ({ track: 1, camera, stamp, image: [640, 480] }) as SeenFace;
const told = (...faces: SeenFace[]) => ({ faces }) as Perceived;

test("only faces of the camera that is shown", () => {
  const all = told(face("kinect_optical_frame", 10), face("imv_optical_frame", 10), face("camera_optical_frame", 10));
  expect(facesOn(all, 10, 0).map(({ camera }) => camera)).toEqual(["kinect_optical_frame", "camera_optical_frame"]);
});

test("only with a picture of about the same time, the nearer the faster the robot turns", () => {
  const all = told(face("kinect_optical_frame", 10));
  expect(facesOn(all, 10.4, 0)).toHaveLength(1);
  expect(facesOn(all, 10.8, 0)).toEqual([]);
  expect(facesOn(all, 10.4, 0.5)).toEqual([]);
  expect(facesOn(all, 10.05, 0.5)).toHaveLength(1);
  expect(facesOn(all, null, 0)).toEqual([]);
});

test("codes of the camera that is shown, and none from programs that tell none", () => {
  const code = { text: "stop", camera: "camera_optical_frame", stamp: 10, corners: [], image: [640, 480] };
  expect(codesOn({ ...told(), codes: [code] } as unknown as Perceived, 10.1, 0)).toEqual([code]);
  expect(codesOn(told(), 10, 0)).toEqual([]);
});
