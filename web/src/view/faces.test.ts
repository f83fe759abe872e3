import { expect, test } from "vitest";
import type { Perceived, SeenFace } from "../protocol/types";
import { codesOn, cutOff, facesOn, nearSide, type Trails, trailed } from "./faces";

const face = (camera: string, stamp: number, left = 100) =>
  ({ track: 1, camera, stamp, image: [640, 480], box: [left, 50, 40, 40] }) as SeenFace;
const message = (...faces: SeenFace[]) => ({ faces }) as Perceived;

test("only faces of the camera that is shown", () => {
  const all = message(
    face("kinect_optical_frame", 10),
    face("panorama_optical_frame", 10),
    face("camera_optical_frame", 10),
  );
  expect(facesOn(trailed(new Map(), all), 10, 0).map(({ camera }) => camera)).toEqual([
    "kinect_optical_frame",
    "camera_optical_frame",
  ]);
});

test("only with a picture of about the same time, the nearer the faster the camera turns", () => {
  const all = message(face("kinect_optical_frame", 10));
  expect(facesOn(trailed(new Map(), all), 10.4, 0)).toHaveLength(1);
  expect(facesOn(trailed(new Map(), all), 10.8, 0)).toEqual([]);
  expect(facesOn(trailed(new Map(), all), 10.4, 0.5)).toEqual([]);
  expect(facesOn(trailed(new Map(), all), 10.05, 0.5)).toHaveLength(1);
  expect(facesOn(trailed(new Map(), all), null, 0)).toEqual([]);
  // At 60°/s the next image of 15 a second is 4° on.
  expect(facesOn(trailed(new Map(), all), 10 + 1 / 15, 1.05)).toEqual([]);
  expect(facesOn(trailed(new Map(), all), 10, 1.05)).toHaveLength(1);
});

test("codes of the camera that is shown, and none without any", () => {
  const code = { text: "stop", camera: "camera_optical_frame", stamp: 10, corners: [], image: [640, 480] };
  expect(codesOn({ ...message(), codes: [code] } as unknown as Perceived, 10.1, 0)).toEqual([code]);
  expect(codesOn(message(), 10, 0)).toEqual([]);
});

/** A person who walks to the right at 240 px/s, seen every 0.15 s up to `until`. */
function walking(until: number): Trails {
  let trails: Trails = new Map();
  for (let stamp = 10; stamp <= until + 1e-6; stamp += 0.15)
    trails = trailed(trails, message(face("camera_optical_frame", stamp, 240 * (stamp - 10))));
  return trails;
}

test("the frame of a walking person is where the face is on a newer picture, or an older one", () => {
  const trails = walking(11.5);
  for (const stamp of [11.2, 11.27, 11.5, 11.6, 11.8]) {
    const [seen] = facesOn(trails, stamp, 0);
    expect(seen!.box[0]).toBeCloseTo(240 * (stamp - 10), 6);
    expect(seen!.box[1]).toBeCloseTo(50, 6);
    expect(seen!.box[2]).toBeCloseTo(40, 6);
  }
});

test("who was seen once stays there, and a jump back in time forgets how a face moved", () => {
  expect(facesOn(walking(10), 10.3, 0)[0]!.box[0]).toBe(0);
  const back = trailed(walking(11.5), message(face("camera_optical_frame", 10.2, 300)));
  expect(facesOn(back, 10.4, 0)[0]!.box[0]).toBe(300);
});

test("a face that is gone has no frame", () => {
  expect(facesOn(trailed(walking(11.5), message()), 11.5, 0)).toEqual([]);
});

test("words of a frame at the picture's side begin or end inside the picture", () => {
  expect([nearSide(-20, 60, 640), cutOff(-20, 60, 640)]).toEqual(["left", 100 / 3]);
  expect([nearSide(610, 40, 640), cutOff(610, 40, 640)]).toEqual(["right", 25]);
  expect([nearSide(300, 40, 640), cutOff(300, 40, 640)]).toEqual(["", 0]);
});
