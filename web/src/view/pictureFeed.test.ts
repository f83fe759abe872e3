import { signal } from "@preact/signals";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { FILE, HEADER_BYTES, PANORAMA } from "../protocol/picture";
import type { Session } from "../state/session";
import { PictureFeed } from "./pictureFeed";

/** Longer than a picture of before a jump stays. */
const LATER_MS = 2000;

function picture(seq: number, stamp: number): ArrayBuffer {
  const frame = new ArrayBuffer(HEADER_BYTES + 4);
  const view = new DataView(frame);
  view.setUint8(0, PANORAMA);
  view.setUint8(1, FILE);
  view.setUint32(4, seq, true);
  view.setFloat64(8, stamp, true);
  view.setUint16(16, 8, true);
  view.setUint16(18, 4, true);
  return frame;
}

function started() {
  const jumps = new Set<() => void>();
  const frames = new Map<number, (frame: ArrayBuffer) => void>();
  const acknowledged: number[] = [];
  const session = {
    onBinary: frames,
    onHello: new Set(),
    onJump: jumps,
    send: (message: { type: string; seq?: number }) => {
      if (message.type === "ack") acknowledged.push(message.seq!);
    },
  } as unknown as Session;
  const feed = new PictureFeed(session, PANORAMA, signal(true), signal(false));
  feed.canvas = { width: 8, height: 4, getContext: () => ({ drawImage: () => undefined }) } as never;
  feed.start();
  return {
    feed,
    jump: () => jumps.forEach((each) => each()),
    come: async (seq: number, stamp: number) => {
      frames.get(PANORAMA)!(picture(seq, stamp));
      await vi.waitFor(() => expect(acknowledged).toContain(seq));
    },
  };
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("window", { setTimeout, clearTimeout });
  vi.stubGlobal("document", {
    hidden: false,
    addEventListener: () => undefined,
    createElement: () => ({ getContext: () => null }),
  });
  vi.stubGlobal("createImageBitmap", async () => ({ width: 8, height: 4, close: () => undefined }));
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("a picture of before a jump goes where none comes", async () => {
  const { feed, come, jump } = started();
  await come(1, 10.5);
  jump();
  expect(feed.stamp.value).toBe(10.5);
  vi.advanceTimersByTime(LATER_MS);
  expect(feed.stamp.value).toBe(null);
});

test("after a jump to where it was, the picture that comes again stays", async () => {
  const { feed, come, jump } = started();
  await come(1, 10.5);
  jump();
  await come(2, 10.5);
  vi.advanceTimersByTime(LATER_MS);
  expect(feed.stamp.value).toBe(10.5);
});
