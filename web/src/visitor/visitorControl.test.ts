import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { LiveHandlers } from "../protocol/live";
import { Problem } from "../protocol/problem";
import type { FromRobot } from "../protocol/types";
import type { VisitorRest } from "../protocol/visitorRest";
import { VisitorControl } from "./visitorControl";

const OUT = new Problem(401, "Login needed", "");

/** A phone in front of a robot that lets in who has the key "k". */
function phone(key: string | null, { inside = false, there = true } = {}) {
  const asked = {
    checkVisitor: vi.fn(async () => {
      if (!there) throw new Problem(0, "No answer", "");
      if (!inside) throw OUT;
    }),
    enterAsVisitor: vi.fn(async (brought: string) => {
      if (brought !== "k") throw OUT;
      inside = true;
    }),
    pressAsVisitor: vi.fn(async () => undefined),
  };
  let handlers!: LiveHandlers;
  const live = { open: vi.fn(() => handlers.opened()), close: vi.fn() };
  const control = new VisitorControl(asked as unknown as VisitorRest, key, (given) => {
    handlers = given;
    return live;
  });
  return {
    asked,
    control,
    live,
    lose: (everOpened: boolean) => handlers.lost(everOpened, 1),
    says: (view: object) => handlers.message({ type: "visitor", ...view } as FromRobot),
    /** The run is over: who is in is out, and the key opens nothing. */
    ends: () => {
      inside = false;
      asked.enterAsVisitor.mockRejectedValue(OUT);
    },
    comes: () => (there = true),
  };
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: vi.fn() });
});
afterEach(() => vi.useRealTimers());

test("the key of the link opens; a phone that is in already does not use it again", async () => {
  const fresh = phone("k");
  await fresh.control.enter();
  expect(fresh.control.phase.value).toBe("live");
  const back = phone("k", { inside: true });
  await back.control.enter();
  expect(back.asked.enterAsVisitor).not.toHaveBeenCalled();
  expect(back.control.phase.value).toBe("live");
});

test("an old link, or none, is over, and is not tried again", async () => {
  for (const key of ["old", null]) {
    const { asked, control, live } = phone(key);
    await control.enter();
    expect(control.phase.value).toBe("over");
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked.checkVisitor).toHaveBeenCalledTimes(1);
    expect(live.open).not.toHaveBeenCalled();
  }
});

test("a robot that does not answer is asked again; one that ended the run is not", async () => {
  const { comes, control, ends, live, lose, says } = phone("k", { there: false });
  await control.enter();
  expect(control.phase.value).toBe("lost");
  comes();
  await vi.advanceTimersByTimeAsync(4000);
  expect(control.phase.value).toBe("live");
  says({ tour: true });
  expect(control.view.value?.tour).toBe(true);

  lose(true);
  expect(control.phase.value).toBe("lost");
  expect(control.view.value).not.toBeNull(); // what was shown stays meanwhile
  await vi.advanceTimersByTimeAsync(0);
  expect(control.phase.value).toBe("live");
  expect(live.close).toHaveBeenCalled(); // it must not open again by itself

  ends();
  lose(true);
  await vi.advanceTimersByTimeAsync(0);
  expect(control.phase.value).toBe("over");
  expect(control.view.value).toBeNull();
});

test("a connection that is refused, for want of room, is not asked for in haste", async () => {
  const { control, live, lose } = phone("k");
  live.open.mockImplementation(() => undefined);
  await control.enter();
  lose(false);
  await vi.advanceTimersByTimeAsync(3000);
  expect(live.open).toHaveBeenCalledTimes(1);
  await vi.advanceTimersByTimeAsync(1000);
  expect(live.open).toHaveBeenCalledTimes(2);
});

test("a press rests for a moment, and a refused one says so for a while", async () => {
  const { asked, control } = phone("k");
  await control.enter();
  await control.press({ button: "agree" });
  await control.press({ button: "agree" });
  expect(asked.pressAsVisitor).toHaveBeenCalledTimes(1); // the second tap
  await vi.advanceTimersByTimeAsync(700);
  asked.pressAsVisitor.mockRejectedValueOnce(new Problem(429, "Too many", ""));
  await control.press({ ask: "weight" });
  expect(control.refusal.value).toBe("tooOften");
  await vi.advanceTimersByTimeAsync(4000);
  expect(control.refusal.value).toBe("");
  asked.pressAsVisitor.mockRejectedValueOnce(new Problem(409, "Refused", ""));
  await control.press({ button: "next" });
  expect(control.refusal.value).toBe("notNow");
});

test("a language is remembered", () => {
  const { control } = phone("k");
  control.choose("fr");
  expect(control.language.value).toBe("fr");
  expect(localStorage.setItem).toHaveBeenCalledWith("hbba.visitor.language", "fr");
});
