import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { LiveConnection, type LiveHandlers } from "./live";

class FakeSocket {
  static readonly OPEN = 1;
  static all: FakeSocket[] = [];
  readyState = 0;
  bufferedAmount = 0;
  binaryType = "";
  sent: Record<string, unknown>[] = [];
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;

  constructor(readonly url: string) {
    FakeSocket.all.push(this);
  }
  send(text: string): void {
    this.sent.push(JSON.parse(text) as Record<string, unknown>);
  }
  close(): void {
    this.readyState = 3;
    this.onclose?.();
  }
  accept(): void {
    this.readyState = 1;
    this.onopen?.();
  }
  say(message: unknown): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
}

const newest = () => FakeSocket.all.at(-1)!;
const drive = (held: boolean) => ({ type: "drive", seq: 1, held, linear: 0, angular: 0 }) as const;

function connect() {
  const handlers = {
    opened: vi.fn(),
    message: vi.fn(),
    binary: vi.fn(),
    roundTrip: vi.fn(),
    lost: vi.fn(),
  } satisfies LiveHandlers;
  const live = new LiveConnection(() => "ws://robot/api/v1/live", handlers);
  live.open();
  return { live, handlers };
}

beforeEach(() => {
  vi.useFakeTimers();
  FakeSocket.all = [];
  vi.stubGlobal("WebSocket", FakeSocket);
  vi.stubGlobal("window", globalThis);
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe("a connection that stands", () => {
  test("pings at once and more often than once a second, with the last round trip", () => {
    const { handlers } = connect();
    newest().accept();
    expect(newest().sent[0]).toMatchObject({ type: "ping", rtt_ms: null });
    vi.advanceTimersByTime(30);
    newest().say({ type: "pong", t: newest().sent[0]!["t"], stamp: 5 });
    expect(handlers.roundTrip).toHaveBeenCalledWith(30);
    vi.advanceTimersByTime(960);
    expect(newest().sent.length).toBe(2);
    expect(newest().sent[1]).toMatchObject({ type: "ping", rtt_ms: 30 });
  });

  test("does not pile held commands up behind a stuck link, but says a release", () => {
    const { live } = connect();
    newest().accept();
    newest().bufferedAmount = 1_000_000;
    expect(live.send(drive(true))).toBe(false);
    expect(live.send(drive(false))).toBe(true);
    expect(live.send({ type: "e_stop" })).toBe(true);
  });
});

describe("what may move something", () => {
  const moving = [
    drive(true),
    { type: "clear_e_stop" },
    { type: "look", stamp: 1000.2, u: 0.5, v: 0.25 },
    { type: "take_control" },
    { type: "ping", rtt_ms: null },
  ] as const;

  test.each(moving)("says when it was sent, and what had been heard by then: $type", (message) => {
    const { live } = connect();
    newest().accept();
    vi.advanceTimersByTime(100);
    newest().say({ type: "status", stamp: 1000.5 });
    const heard_t = performance.now();
    vi.advanceTimersByTime(30);
    newest().say({ type: "lanes", stamp: 1000.6 });
    live.send(message);
    expect(newest().sent.at(-1)).toMatchObject({ ...message, t: heard_t + 30, heard: 1000.5, heard_t });
    newest().say({ type: "pong", t: 1, stamp: 1001 });
    live.send(message);
    expect(newest().sent.at(-1)).toMatchObject({ heard: 1001, heard_t: heard_t + 30 });
  });

  test("says nothing of what another connection heard", () => {
    const { live } = connect();
    newest().accept();
    newest().say({ type: "hello", stamp: 1000.5 });
    newest().close();
    vi.advanceTimersByTime(1000);
    newest().accept();
    live.send(drive(true));
    expect(newest().sent.at(-1)).not.toHaveProperty("heard");
  });

  test("the emergency stop needs no time", () => {
    const { live } = connect();
    newest().accept();
    live.send({ type: "e_stop" });
    expect(newest().sent.at(-1)).toEqual({ type: "e_stop" });
  });
});

describe("a connection that is lost", () => {
  test("is opened again, more and more patiently, and at once patiently no more when it stood", () => {
    const { handlers } = connect();
    const waits: number[] = [];
    for (let i = 0; i < 8; i++) {
      newest().close();
      waits.push(handlers.lost.mock.lastCall![1] as number);
      vi.advanceTimersByTime(waits.at(-1)! + 1);
      expect(FakeSocket.all.length).toBe(i + 2);
    }
    expect(waits[0]).toBeLessThanOrEqual(480);
    expect(waits[7]).toBeGreaterThan(3900);
    expect(Math.max(...waits)).toBeLessThanOrEqual(6000);
    newest().accept();
    newest().close();
    expect(handlers.lost.mock.lastCall![0]).toBe(true);
    expect(handlers.lost.mock.lastCall![1]).toBeLessThanOrEqual(480);
  });

  test("silence is a loss, even if the socket looks open", () => {
    const { handlers } = connect();
    newest().accept();
    vi.advanceTimersByTime(3500);
    newest().say({ type: "notice", level: "info", text: "here" });
    vi.advanceTimersByTime(3500);
    expect(handlers.lost).not.toHaveBeenCalled();
    vi.advanceTimersByTime(1100);
    expect(handlers.lost).toHaveBeenCalledTimes(1);
  });

  test("closed for good stays closed, and nothing is sent", () => {
    const { live, handlers } = connect();
    newest().accept();
    live.close();
    vi.advanceTimersByTime(60_000);
    expect(handlers.lost).not.toHaveBeenCalled();
    expect(FakeSocket.all.length).toBe(1);
    expect(live.send({ type: "e_stop" })).toBe(false);
  });
});
