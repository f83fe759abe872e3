/** The sound of the live stream, both ways: 24 bytes of little-endian header, then int16 samples of one channel. */

export const HEARD = 16;
export const SPOKEN = 17;
const HEADER_BYTES = 24;

export interface Sound {
  seq: number;
  /** The robot's time of the first sample, s. */
  stamp: number;
  /** Samples a second. */
  rate: number;
  samples: Int16Array<ArrayBuffer>;
}

/** Reads one frame of kind 16; null if it is none, is cut short or has more than one channel. */
export function parseSound(frame: ArrayBuffer): Sound | null {
  if (frame.byteLength < HEADER_BYTES) return null;
  const view = new DataView(frame);
  const count = view.getUint16(16, true);
  const rate = view.getUint32(20, true);
  if (view.getUint8(0) !== HEARD || view.getUint16(18, true) !== 1 || rate === 0) return null;
  if (frame.byteLength !== HEADER_BYTES + 2 * count) return null;
  return {
    seq: view.getUint32(4, true),
    stamp: view.getFloat64(8, true),
    rate,
    samples: new Int16Array(frame, HEADER_BYTES, count),
  };
}

/** One frame of the operator's voice, kind 17; of no samples, it ends the talk. */
export function packVoice(sound: Sound): ArrayBuffer {
  const frame = new ArrayBuffer(HEADER_BYTES + 2 * sound.samples.length);
  const view = new DataView(frame);
  view.setUint8(0, SPOKEN);
  view.setUint32(4, sound.seq, true);
  view.setFloat64(8, sound.stamp, true);
  view.setUint16(16, sound.samples.length, true);
  view.setUint16(18, 1, true);
  view.setUint32(20, sound.rate, true);
  new Int16Array(frame, HEADER_BYTES).set(sound.samples);
  return frame;
}
