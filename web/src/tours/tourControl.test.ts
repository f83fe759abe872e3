import { signal } from "@preact/signals";
import { expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { KeptTour, TourRest } from "../protocol/tourRest";
import type { Tour } from "../protocol/types";
import { createStore } from "../state/store";
import { TourControl } from "./tourControl";
import { stopChanged, withStop } from "./tourEdits";
import { aStop, aTour } from "./tours.fixture";

/** A robot that keeps one tour, by its rules: a change of another version is refused. */
class Robot {
  version = 1;
  tour: Tour = aTour([aStop("a"), aStop("b")]);
  before: Tour[] = [];
  refuses: Problem | null = null;
  /** Called before a change is judged: another editor's chance. */
  meanwhile: () => void = () => undefined;
  readonly sent: Tour[] = [];

  get rest(): TourRest {
    const rest = {
      tour: async () => this.kept(),
      tours: async () => ({ folder: "", tours: [{ id: "lab", etag: this.etag }] }),
      replaceTour: async (_: string, tour: Tour, etag: string) => {
        this.sent.push(tour);
        this.meanwhile();
        if (this.refuses) throw this.refuses;
        if (etag !== this.etag) throw new Problem(412, "Changed meanwhile", "It was changed since you read it.");
        this.change(tour);
        return this.kept();
      },
      undoTour: async () => {
        this.tour = this.before.pop()!;
        this.version++;
        return this.kept();
      },
      deleteTour: vi.fn(async () => undefined),
    };
    return rest as unknown as TourRest;
  }

  get etag(): string {
    return `"${this.version}"`;
  }

  kept(): KeptTour {
    const tour = structuredClone(this.tour) as unknown as Record<string, unknown>;
    return { tour, shipped: false, can_undo: this.before.length > 0, can_redo: false, problems: [], etag: this.etag };
  }

  change(tour: Tour): void {
    this.before.push(this.tour);
    this.tour = tour;
    this.version++;
  }
}

async function opened(robot: Robot) {
  const store = createStore();
  const tours = new TourControl(store, robot.rest, signal(true));
  await tours.open("lab");
  return { store, tours };
}

test("an edit shows at once, and is kept by the robot", async () => {
  const robot = new Robot();
  const { tours } = await opened(robot);
  const kept = tours.edit((tour) => stopChanged(tour, "a", { place: "door" }));
  expect(tours.draft.value?.stops[0]?.place).toBe("door");
  expect(tours.unsaved.value).toBe(true);
  await kept;
  expect(tours.unsaved.value).toBe(false);
  expect(robot.tour.stops[0]?.place).toBe("door");
});

test("edits that come while one is sent follow it, each on the version that it meets", async () => {
  const robot = new Robot();
  const { tours } = await opened(robot);
  void tours.edit((tour) => ({ ...tour, home: "dock" }));
  void tours.edit((tour) => withStop(tour, aStop("c")));
  await tours.edit((tour) => ({ ...tour, title: { en: "New" } }));
  expect(robot.tour).toMatchObject({ home: "dock", title: { en: "New" } });
  expect(robot.tour.stops.length).toBe(3);
  expect(robot.sent.length).toBe(2);
});

test("another editor's change of something else is joined", async () => {
  const robot = new Robot();
  const { store, tours } = await opened(robot);
  robot.change({ ...robot.tour, home: "dock" });
  await tours.edit((tour) => stopChanged(tour, "b", { place: "door" }));
  expect(robot.tour).toMatchObject({ home: "dock", stops: [{ id: "a" }, { id: "b", place: "door" }] });
  expect(tours.conflict.value).toBeNull();
  expect(store.notices.value[0]?.text).toContain("both changes");
});

for (const whose of ["mine", "theirs"] as const)
  test(`what both have changed waits for people, who choose ${whose}`, async () => {
    const robot = new Robot();
    const { tours } = await opened(robot);
    robot.change({ ...robot.tour, title: { en: "Theirs" }, home: "dock" });
    await tours.edit((tour) => stopChanged({ ...tour, title: { en: "Mine" } }, "a", { place: "door" }));
    expect(tours.conflict.value?.paths).toEqual(["title.en"]);
    expect(robot.tour.title).toEqual({ en: "Theirs" });
    await tours.decide(whose);
    expect(tours.conflict.value).toBeNull();
    expect(robot.tour.title).toEqual({ en: whose === "mine" ? "Mine" : "Theirs" });
    expect(robot.tour).toMatchObject({ home: "dock", stops: [{ place: "door" }, { id: "b" }] });
  });

test("a mistake is shown where it is, and the next right edit takes all", async () => {
  const robot = new Robot();
  const { tours } = await opened(robot);
  robot.refuses = new Problem(422, "Invalid", "stops.0.place: should be a place's id.", [
    { field: "stops.0.place", message: "should be a place's id" },
  ]);
  await tours.edit((tour) => stopChanged(tour, "a", { place: "?" }));
  expect(tours.problems.value).toEqual([
    { field: "stops.0.place", message: "should be a place's id", severity: "mistake" },
  ]);
  expect([tours.unsaved.value, tours.draft.value?.stops[0]?.place]).toEqual([true, "?"]);
  robot.refuses = null;
  await tours.edit((tour) => stopChanged(tour, "a", { place: "door" }));
  expect([tours.problems.value, tours.refusal.value, robot.tour.stops[0]?.place]).toEqual([[], "", "door"]);
});

test("undo is the robot's, and takes back what is shown", async () => {
  const robot = new Robot();
  const { tours } = await opened(robot);
  await tours.edit((tour) => ({ ...tour, home: "dock" }));
  expect(tours.kept.value?.can_undo).toBe(true);
  await tours.undo();
  expect(tours.draft.value?.home).toBeNull();
});

test("a tour that another editor has changed is read again, as long as nothing here would be lost", async () => {
  const robot = new Robot();
  const { tours } = await opened(robot);
  robot.change({ ...robot.tour, home: "dock" });
  await tours.refresh();
  expect(tours.draft.value?.home).toBe("dock");
  robot.refuses = new Problem(422, "Invalid", "No.");
  await tours.edit((tour) => ({ ...tour, home: "?" }));
  robot.change({ ...robot.tour, home: "hall" });
  await tours.refresh();
  expect(tours.draft.value?.home).toBe("?");
});

test("without an answer nothing is lost", async () => {
  const robot = new Robot();
  const { tours } = await opened(robot);
  robot.refuses = new Problem(0, "No answer", "The robot did not answer.");
  await tours.edit((tour) => ({ ...tour, home: "dock" }));
  expect([tours.unsaved.value, tours.refusal.value]).toEqual([true, "The robot did not answer."]);
  robot.refuses = null;
  await tours.save();
  expect(robot.tour.home).toBe("dock");
});
