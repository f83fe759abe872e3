import { expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Playback } from "../protocol/types";
import { createStore } from "../state/store";
import { PlaybackController } from "./playbackController";

const STATE: Playback = {
  file: "a.mcap",
  begin: 100,
  end: 160,
  position: 130,
  speed: 1,
  playing: true,
  phase: "playing",
  problem: null,
};

function replay(state: Partial<Playback> = {}, refusal?: Problem) {
  const store = createStore();
  const now = { ...STATE, ...state };
  store.clock.begin(now, 0);
  store.playback.value = now;
  const answer = async (change: Partial<Playback>) => (refusal ? Promise.reject(refusal) : { ...now, ...change });
  const asked = { playback: vi.fn(answer), stepPlayback: vi.fn(() => answer({ playing: false, phase: "paused" })) };
  return { store, asked, control: new PlaybackController(store, asked as unknown as Rest) };
}

const settled = () => new Promise((resolve) => setTimeout(resolve, 120));

test("plays, pauses, and from the end begins again", () => {
  for (const [state, change] of [
    [{}, { playing: false }],
    [{ playing: false, phase: "paused" }, { playing: true }],
    [
      { playing: false, phase: "ended", position: 160 },
      { position: 100, playing: true },
    ],
  ] as const) {
    const { control, asked } = replay(state);
    control.act("toggle");
    expect(asked.playback).toHaveBeenCalledWith(change);
  }
});

test("skips add up from where the hand is, not from where the robot is yet", async () => {
  const { control, asked, store } = replay();
  control.act("skip");
  control.act("skip");
  expect(control.wanted.value).toBe(140);
  await settled();
  await settled();
  expect(asked.playback.mock.calls).toEqual([[{ position: 135 }], [{ position: 140 }]]);
  expect(control.wanted.value).toBeNull();
  expect(store.playback.value!.position).toBe(140);
});

test("what is asked while it still seeks waits for it, and goes by what is true then", async () => {
  const { control, asked, store } = replay({ playing: false, phase: "ended", position: 160 });
  asked.playback.mockImplementationOnce(async (change) => ({ ...store.playback.value!, ...change, phase: "paused" }));
  control.act("begin");
  control.act("step");
  control.act("toggle");
  expect(asked.stepPlayback).not.toHaveBeenCalled();
  await settled();
  expect(asked.stepPlayback).toHaveBeenCalledOnce();
  expect(asked.playback.mock.calls).toEqual([[{ position: 100 }], [{ playing: true }]]);
});

test("a step back looks at a moment, which does not run away again, and two go twice as far", async () => {
  const { control, asked } = replay();
  control.act("back");
  control.act("back");
  await settled();
  await settled();
  expect(asked.playback.mock.calls[0]).toEqual([{ playing: false }]);
  expect(asked.playback.mock.calls.at(-1)).toEqual([{ position: 129.8 }]);
});

test("an answer is taken before the next report comes", async () => {
  const { control, store } = replay();
  control.act("step");
  await settled();
  expect(store.playback.value).toMatchObject({ playing: false, phase: "paused", begin: 100 });
});

test("a refusal is reported, and the timeline goes back", async () => {
  const { control, store } = replay({}, new Problem(409, "Damaged", "the recording is damaged there"));
  control.seek(150);
  await settled();
  expect(store.notices.value.map((notice) => notice.text)).toEqual(["The recording is damaged there."]);
  expect(control.wanted.value).toBeNull();
  expect(store.playback.value!.position).toBe(130);
});

test("does nothing where no recording is shown", () => {
  const { control, store, asked } = replay();
  store.playback.value = null;
  control.act("toggle");
  control.act("skip");
  expect(asked.playback).not.toHaveBeenCalled();
});
