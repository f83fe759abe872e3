import { signal } from "@preact/signals";
import { h } from "preact";
import { expect, test, vi } from "vitest";
import type { Tour, TourProblemReport } from "../protocol/types";
import { drawn } from "../ui/page.fixture";
import { StopList } from "./StopList";
import type { Leg } from "./tourRoute";
import { aStop, aTour } from "./tours.fixture";

const BLOCKED: Leg = { stop: "desk", state: "none", reason: "no way", length_m: 0, duration_s: 0, path: [] };

function shown() {
  vi.stubGlobal("requestAnimationFrame", () => 0); // there is no focus to keep here
  const draft = signal<Tour>(aTour(["arm", "desk", "door"].map((id) => aStop(id))));
  const edit = vi.fn(async (change: (tour: Tour) => Tour) => void (draft.value = change(draft.peek())));
  const tours = { draft, edit, problems: signal<TourProblemReport[]>([]) };
  const page = drawn(h(StopList, null), {
    tours,
    stops: { open: signal(null) },
    tourRoute: { legs: signal([BLOCKED]) },
  });
  const row = (id: string) => page.all("tour-stop").find(({ attributes }) => attributes.get("data-stop") === id)!;
  const opener = (id: string) =>
    row(id)
      .all()
      .find(({ attributes }) => attributes.get("data-testid") === "stop-open")!;
  return {
    page,
    edit,
    row,
    order: () => page.all("tour-stop").map(({ attributes }) => attributes.get("data-stop")),
    key: (id: string, key: string, altKey = true) => page.fire(opener(id), "keydown", { key, altKey }),
  };
}

test("a stop that is dropped on another takes its place", async () => {
  const { page, row, order } = shown();
  const setData = vi.fn();
  await page.fire(row("arm"), "dragstart", { dataTransfer: { setData } });
  expect(setData).toHaveBeenCalledWith("text/plain", "arm");
  expect(row("arm").attributes.get("class")).toContain("dragged");
  expect((await page.fire(row("door"), "dragover")).defaultPrevented).toBe(true); // else nothing could be dropped there
  await page.fire(row("door"), "drop");
  await page.fire(row("arm"), "dragend");
  expect(order()).toEqual(["desk", "door", "arm"]);
  expect(page.words()).toContain("arm is stop 3 of 3.");
  expect(row("arm").attributes.get("class")).not.toContain("dragged");
});

test("what is dropped where it was, or is no stop, moves nothing", async () => {
  const { page, row, edit } = shown();
  await page.fire(row("arm"), "drop");
  await page.fire(row("arm"), "dragstart", {});
  await page.fire(row("arm"), "drop");
  expect(edit).not.toHaveBeenCalled();
});

test("Alt and the arrow keys move a stop, and nothing else sees the key", async () => {
  const { key, order } = shown();
  expect((await key("arm", "ArrowDown")).defaultPrevented).toBe(true);
  expect(order()).toEqual(["desk", "arm", "door"]);
  await key("door", "ArrowUp");
  expect(order()).toEqual(["desk", "door", "arm"]);
});

test("beyond the ends, without Alt, or by another key no stop moves", async () => {
  const { key, edit } = shown();
  await key("arm", "ArrowUp");
  await key("door", "ArrowDown");
  await key("arm", "ArrowLeft");
  expect((await key("arm", "ArrowDown", false)).defaultPrevented).toBe(false); // the page scrolls
  expect(edit).not.toHaveBeenCalled();
});

test("a leg that cannot be driven is red in the list, and says why", () => {
  const leg = shown().page.one("tour-leg");
  expect(leg.attributes.get("class")).toBe("tour-leg none");
  expect(leg.textContent).toBe("Stop 2: Cannot be driven: no way");
});
