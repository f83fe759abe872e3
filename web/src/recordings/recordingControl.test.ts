import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Message } from "../state/latest";
import { createStore } from "../state/store";
import { RecordingControl } from "./recordingControl";

const IDLE: Message<"recorder"> = {
  type: "recorder",
  stamp: 0,
  state: "idle",
  name: "",
  began: null,
  duration_s: 0,
  bytes: 0,
  messages: 0,
  dropped: 0,
  queued_bytes: 0,
  keep_minutes: 0,
  desired: false,
  reason: "",
  available: true,
};
const RECORDING: Message<"recorder"> = { ...IDLE, state: "recording", name: "a", began: 1000, desired: true };

function page(rest: Partial<Rest> = {}) {
  const store = createStore();
  const list = { folder: "", free_bytes: 1, recorder: null, replay: null, recordings: [] };
  const asked = {
    recordings: vi.fn(async () => list),
    record: vi.fn(async () => {}),
    stopRecording: vi.fn(async () => {}),
  };
  const control = new RecordingControl(store, { ...asked, ...rest } as unknown as Rest);
  control.start();
  store.latest.put(IDLE);
  return { store, control, asked, notices: () => store.notices.value.map((notice) => notice.text) };
}

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

test("recording is being started until the Recorder says that it records", async () => {
  const { store, control, asked } = page();
  await control.record({ name: "a" });
  expect(asked.record).toHaveBeenCalledWith({ name: "a" });
  expect(control.pending.value).toBe("start");
  store.latest.put(RECORDING);
  expect(control.pending.value).toBeNull();
  await control.stop();
  expect(control.pending.value).toBe("stop");
  store.latest.put(IDLE);
  expect(control.pending.value).toBeNull();
});

test("a recording that does not start gives its reason after a while", async () => {
  const { store, control, notices } = page();
  await control.record({});
  store.latest.put({ ...IDLE, desired: true, reason: "no room on the computer" });
  vi.advanceTimersByTime(10_000);
  expect(control.pending.value).toBeNull();
  expect(notices()).toEqual(["The recording did not start. No room on the computer."]);
});

test("a refusal is shown in the tab, and ends the waiting", async () => {
  const refuse = async () => Promise.reject(new Problem(409, "Taken", "There is one called a."));
  const { store, control, notices } = page({ record: refuse });
  expect(await control.record({ name: "a" })).toBe(false);
  expect([control.pending.value, control.problem.value]).toEqual([null, "There is one called a."]);
  expect(notices()).toEqual(["There is one called a."]);
  store.recordingsShown.value = true;
  await control.record({ name: "a" });
  expect(notices()).toHaveLength(1);
});

test("a recording that stops by itself is reported once, and the list is read again while it is looked at", () => {
  const { store, asked, notices } = page();
  store.latest.put(RECORDING);
  expect(asked.recordings).not.toHaveBeenCalled();
  store.recordingsShown.value = true;
  expect(asked.recordings).toHaveBeenCalledTimes(1);
  store.latest.put({ ...RECORDING, state: "stopped", reason: "the disk is full" });
  store.latest.put({ ...RECORDING, state: "stopped", reason: "the disk is full", duration_s: 3 });
  expect(notices()).toEqual(["Recording has stopped. The disk is full."]);
});
