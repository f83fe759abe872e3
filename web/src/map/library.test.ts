import { signal } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Hello, KeptMaps } from "../protocol/types";
import type { Message } from "../state/latest";
import { createStore } from "../state/store";
import { MapLibrary } from "./library";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const kept = (name: string, available = true): KeptMaps => ({
  folder: "maps",
  current: { available, name, state: available ? "tracking" : null, stamp: null },
  maps: [],
});

/** A page that looks at the maps of a robot, whose map in use is `robot.name`. */
function page({ name = "third", map = true, shown = true } = {}) {
  const robot = { name, available: true };
  const rest = {
    maps: vi.fn(async () => kept(robot.available ? robot.name : "", robot.available)),
    saveMap: vi.fn(async (to: string) => void (robot.name = to)),
    loadMap: vi.fn(async (to: string) => void (robot.name = to)),
    renameMap: vi.fn(async (_: string, to: string) => void (robot.name = to)),
    beginMap: vi.fn(async () => void (robot.name = "")),
  };
  const store = createStore();
  const looks = signal(shown);
  const library = new MapLibrary(store, rest as unknown as Rest, looks, async () => {});
  library.start();
  store.hello.value = { channels: { map } } as Hello;
  store.link.value = { phase: "live", retryAt: 0 };
  const scan = (on: string) =>
    store.latest.put({ type: "localization", map: on } as unknown as Message<"localization">);
  const settle = () => vi.advanceTimersByTimeAsync(0);
  return {
    robot,
    rest,
    store,
    looks,
    library,
    scan,
    settle,
    notices: () => store.notices.value.map(({ text }) => text),
  };
}

describe("the map in use", () => {
  test("is what it was saved as, though SLAM rests and no scan comes", async () => {
    const { library, scan, settle, notices } = page();
    scan("third");
    await settle();
    await library.save("fourth");
    expect(library.inUse.value).toBe("fourth");
    expect(notices()).toEqual(["Saved as fourth."]);
  });

  test("is what it was renamed to, loaded as, or started", async () => {
    const { library, scan, settle } = page();
    scan("third");
    await settle();
    await library.rename("third", "3rd");
    expect(library.inUse.value).toBe("3rd");
    await library.load("fifth", { extend: false });
    expect(library.inUse.value).toBe("fifth");
    await library.begin();
    expect(library.inUse.value).toBe("");
  });

  test("is not what it was called in scans that were under way meanwhile", async () => {
    const { library, scan, settle } = page();
    scan("third");
    await settle();
    await library.save("fourth");
    scan("third");
    expect(library.inUse.value).toBe("fourth");
    scan("fourth");
    await settle();
    expect(library.inUse.value).toBe("fourth");
  });

  test("is another as soon as a scan is localized, whatever list was being read then", async () => {
    const { robot, library, rest, scan, settle } = page();
    scan("third");
    await settle();
    let answer = (_: KeptMaps) => {};
    rest.maps.mockImplementationOnce(() => new Promise((resolve) => (answer = resolve)));
    void library.refresh();
    robot.name = "other";
    scan("other");
    expect(library.inUse.value).toBe("other");
    answer(kept("third"));
    await settle();
    expect(library.inUse.value).toBe("other");
    expect(library.list.value!.current.name).toBe("other");
  });

  test("is asked for again and again while it is looked at: others save, too", async () => {
    const { robot, library, rest, looks, settle } = page();
    await settle();
    robot.name = "theirs";
    await vi.advanceTimersByTimeAsync(5000);
    expect(library.inUse.value).toBe("theirs");
    looks.value = false;
    const before = rest.maps.mock.calls.length;
    await vi.advanceTimersByTimeAsync(60_000);
    expect(rest.maps.mock.calls.length).toBe(before);
  });

  test("is as it was while the module that keeps maps starts", async () => {
    const { robot, library, settle } = page();
    await settle();
    robot.available = false;
    await library.refresh();
    expect([library.available.value, library.inUse.value]).toEqual([false, "third"]);
    robot.available = true;
    await vi.advanceTimersByTimeAsync(1000);
    expect(library.available.value).toBe(true);
  });

  test("is what scans say where no list is read, as of a recording", () => {
    const { library, scan } = page({ shown: false });
    scan("then");
    expect(library.inUse.value).toBe("then");
  });
});

test("a list that could not be read says so until it can", async () => {
  const { library, rest } = page({ shown: false });
  rest.maps.mockRejectedValueOnce(new Problem(0, "No answer", "The robot did not answer."));
  await library.refresh();
  expect(library.unread.value).toBe("The robot did not answer.");
  await library.refresh();
  expect(library.unread.value).toBe("");
});

test("nothing is asked of a body that makes no map", async () => {
  const { rest, settle } = page({ map: false });
  await settle();
  expect(rest.maps).not.toHaveBeenCalled();
});
