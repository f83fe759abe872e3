import { expect, test } from "vitest";
import { CAMERA, parsePicture } from "./picture";

test("a frame is read as it is laid out", () => {
  const frame = new ArrayBuffer(24 + 3);
  const view = new DataView(frame);
  view.setUint8(0, CAMERA);
  view.setUint32(4, 4_000_000_001, true);
  view.setFloat64(8, 1_790_000_000.25, true);
  view.setUint16(16, 640, true);
  view.setUint16(18, 480, true);
  new Uint8Array(frame).set([0xff, 0xd8, 0xff], 24);
  const picture = parsePicture(frame);
  expect(picture).toMatchObject({ kind: 1, seq: 4_000_000_001, stamp: 1_790_000_000.25, width: 640, height: 480 });
  expect([...picture!.data]).toEqual([0xff, 0xd8, 0xff]);
});

test("a frame without a picture is refused", () => {
  expect(parsePicture(new ArrayBuffer(24))).toBeNull();
  expect(parsePicture(new ArrayBuffer(3))).toBeNull();
});
