/** The pictures of the live stream: 24 bytes of little-endian header, then a JPEG, a frame of VP9, or of maps a PNG. */

import type { AckMessage } from "./generated";

export const CAMERA = 1;
export const PANORAMA = 2;
export const MAP = 3;
export const COSTMAP = 4;
export const HEADER_BYTES = 24;

/** A JPEG or PNG; VP9 that begins afresh; VP9 that needs those before it. */
export const FILE = 0;
export const VP9_KEY = 1;
export const VP9_DELTA = 2;

export interface Picture {
  kind: AckMessage["kind"];
  /** {@link FILE}, {@link VP9_KEY} or {@link VP9_DELTA}. */
  coding: number;
  seq: number;
  stamp: number;
  width: number;
  height: number;
  data: Uint8Array<ArrayBuffer>;
}

/** Reads one binary frame; null if it is too short to be one. */
export function parsePicture(frame: ArrayBuffer): Picture | null {
  if (frame.byteLength <= HEADER_BYTES) return null;
  const view = new DataView(frame);
  return {
    kind: view.getUint8(0) as Picture["kind"],
    coding: view.getUint8(1),
    seq: view.getUint32(4, true),
    stamp: view.getFloat64(8, true),
    width: view.getUint16(16, true),
    height: view.getUint16(18, true),
    data: new Uint8Array(frame, HEADER_BYTES),
  };
}
