import { describe, expect, test } from "vitest";
import type { Desire, LaneRow, LocalizationReport, Navigation, Place } from "../protocol/types";
import { emptyWords, goalOf, hintWords, lengthWords, placeWords, poseWords, wayWords } from "./mapText";
import { AT_REST, type Tools } from "./mapTools";

const desire = (some: Partial<Desire>): Desire => ({
  id: "d1",
  class: "GoTo",
  intensity: 8,
  utility: 1,
  security: false,
  params: { x: 3, y: 4 },
  source: { kind: "operator", name: "Ann", rule: "", event: "", applied: null, motive: null },
  created: 10,
  expires: null,
  modulation: null,
  ...some,
});
const row = (some: Partial<LaneRow>): LaneRow => ({
  class: "GoTo",
  intensity: 8,
  utility: 1,
  rate: 1,
  divisor: 1,
  divisors: {},
  state: "fulfilled",
  text: "",
  ...some,
});
const going = (some: Partial<Navigation>): Navigation => ({
  stamp: 1,
  behavior: "PlanAndFollowPath",
  state: "following",
  reason: "",
  goal: { x: 3, y: 4, theta: null },
  target: { x: 3, y: 4, theta: null },
  remaining_m: 4.21,
  recoveries: 0,
  desire: "d1",
  path: [],
  given_up: null,
  ...some,
});
const place = (some: Partial<LocalizationReport>): LocalizationReport => ({
  stamp: 1,
  state: "tracking",
  map: "lab",
  x: 0,
  y: 0,
  theta: 0,
  sigma: [0.02, 0.03, 0.01],
  X_MO: { x: 0, y: 0, theta: 0 },
  overlap: 0.9,
  ...some,
});

describe("the goal that counts", () => {
  test("is the most intense desire's, of equals the newest's", () => {
    const goals = [
      desire({ id: "a", intensity: 4 }),
      desire({ id: "b", created: 11 }),
      desire({ id: "c", created: 12, params: { x: 1, y: 2, heading: 0.5 } }),
      desire({ id: "d", class: "SLAM" }),
    ];
    expect(goalOf(goals)).toEqual({ x: 1, y: 2, theta: 0.5, id: "c", asked: true, name: "" });
  });

  test("has the name of the place that it was given by", () => {
    const params = { x: 1, y: 2, heading: 0.5, place: "lab", name: "Robotics lab" };
    expect(goalOf([desire({ params })])!.name).toBe("Robotics lab");
  });

  test("is none without a trip, or where it may not go", () => {
    expect(goalOf(null)).toBeNull();
    expect(goalOf([desire({ utility: 0 })])).toBeNull();
  });

  test("of a motivation is not the console's", () => {
    expect(
      goalOf([
        desire({ source: { kind: "motivation", name: "Tour", rule: "", event: "", applied: null, motive: null } }),
      ])!.asked,
    ).toBe(false);
  });
});

describe("the place", () => {
  test("is on the map by the name that it has now, whatever the last scan called it", () => {
    const resting = row({ class: "SLAM", divisor: null, state: "undesired" });
    expect(poseWords(place({ map: "third" }), resting, "fourth").text).toBe("Last pose on fourth");
    expect(poseWords(place({ map: "", state: "mapping" }), undefined, "fourth").text).toBe("Extending fourth");
    expect(poseWords(place({ map: "third" })).text).toBe("On the map third");
  });
});

describe("the way", () => {
  const goal = goalOf([desire({})]);
  const way = (some: Partial<Navigation>) => wayWords(going(some), goal, [row({})]);

  test("shows what is left of it", () => {
    expect(way({})).toEqual({ tone: "good", text: "Going to (3.0, 4.0), 4.2 m left", more: "" });
  });

  test("to the start is called so", () => {
    const home = goalOf([desire({ params: { x: 0, y: 0, heading: 0 } })]);
    expect(wayWords(going({ goal: { x: 0, y: 0, theta: 0 }, target: null }), home, [])!.text).toMatch(/to the start/);
    expect(placeWords({ x: 0.01, y: -0.02 })).toBe("the start");
  });

  test("waits, is stuck, or does not exist, and says why", () => {
    expect(way({ state: "waiting", reason: "a person is in the way" })).toMatchObject({
      tone: "warn",
      more: "A person is in the way.",
    });
    expect(way({ state: "recovering", recoveries: 2 })!.text).toMatch(/recovery 2/);
    expect(way({ state: "unreachable", reason: "walls all around" })).toEqual({
      tone: "bad",
      text: "No path to (3.0, 4.0)",
      more: "Walls all around.",
    });
  });

  test("is not stuck where the robot only does not know its place", () => {
    const turning = { state: "recovering", reason: "it is lost on the map: turning to find itself" } as const;
    const words = (state: LocalizationReport["state"], recoveries = 1) =>
      wayWords(going({ ...turning, recoveries }), goal, [row({})], null, place({ state }));
    for (const astray of ["lost", "searching"] as const)
      expect(words(astray)).toEqual({
        tone: "warn",
        text: "Localizing, then going to (3.0, 4.0)",
        more: "It is lost on the map: turning to find itself.",
      });
    expect(words("tracking")!.text).toMatch(/^Stuck on the way/);
    expect(words("tracking", 0)!.text).toMatch(/^Localizing/); // it has just been found
  });

  test("may end near what cannot be reached", () => {
    expect(way({ target: { x: 3, y: 3.2, theta: null } })!.more).toMatch(/stops 0.8 m from it/);
  });

  test("is over on arrival, though the desire is gone", () => {
    expect(wayWords(going({ state: "arrived" }), null, [])!.text).toBe("Arrived at (3.0, 4.0)");
    expect(wayWords(going({ state: "idle", goal: null }), null, [])).toBeNull();
    expect(wayWords(going({ state: "arrived", stamp: 10 }), null, [], 20)).not.toBeNull();
    expect(wayWords(going({ state: "arrived", stamp: 10 }), null, [], 60)).toBeNull();
  });

  test("to a place is called as that is, also when it is over", () => {
    const places = [{ id: "lab", name: "Robotics lab", x: 3, y: 4.04 } as Place];
    const words = (state: Navigation["state"]) => wayWords(going({ state }), null, [], null, null, places);
    expect(words("following")!.text).toMatch(/^Going to Robotics lab/);
    expect(words("arrived")!.text).toBe("Arrived at Robotics lab");
    expect(placeWords({ x: 3, y: 4.1 }, places)).toBe("(3.0, 4.1)");
    // The place has moved since: the goal has not.
    const named = goalOf([desire({ params: { x: 3, y: 4, name: "Lab" } })]);
    expect(wayWords(going({}), named, [], null, null, [])!.text).toMatch(/^Going to Lab/);
  });

  test("to a new goal is not yet that to the old one", () => {
    const other = goalOf([desire({ params: { x: -2, y: 0 } })]);
    expect(wayWords(going({ state: "arrived" }), other, [row({})])).toMatchObject({
      tone: "busy",
      text: "Setting out for (−2.0, 0.0)…",
    });
  });

  test("that attention does not allow says so in attention's words", () => {
    const refused = row({ state: "unfulfilled", divisor: null, text: "unfulfilled: needs 20 % more cpu" });
    expect(wayWords(null, goal, [refused])).toEqual({
      tone: "warn",
      text: "Not going to (3.0, 4.0)",
      more: "Needs 20 % more CPU.",
    });
  });
});

test.each([
  ["mapping", "", "Mapping, not saved yet", "good"],
  ["mapping", "lab", "Extending lab", "good"],
  ["tracking", "lab", "On the map lab", "good"],
  ["searching", "lab", "Searching for its pose on lab", "warn"],
  ["lost", "lab", "Lost on lab", "bad"],
] as const)("%s on %s: %s", (state, map, text, tone) => {
  expect(poseWords(place({ state, map }))).toMatchObject({ text, tone });
});

test("a pose is old while SLAM is off", () => {
  const past = poseWords(place({}), row({ class: "SLAM", divisor: null, state: "unfulfilled" }));
  expect(past).toMatchObject({ tone: "warn", text: "Last pose on lab" });
  expect(poseWords(place({}), row({ class: "SLAM", divisor: 4 })).tone).toBe("good");
});

test("how sure it is", () => {
  expect(poseWords(place({})).more).toBe("±3 cm, ±0.6°");
  expect(lengthWords(0.05)).toBe("5 cm");
  expect(lengthWords(20)).toBe("20 m");
});

describe("no map", () => {
  const closed = row({ class: "SLAM", divisor: null, state: "undesired" });

  test("without a desire for it: one can be added", () => {
    expect(emptyWords(true, false, closed, null)).toMatchObject({
      text: "No map yet: SLAM is not running.",
      desire: true,
    });
  });

  test("because attention has no room for it", () => {
    const words = emptyWords(
      true,
      false,
      { ...closed, state: "unfulfilled", text: "unfulfilled: needs 8 % more" },
      null,
    );
    expect(words).toMatchObject({ more: "Needs 8 % more.", desire: false });
  });

  test("because there never is one", () => {
    expect(emptyWords(true, false, undefined, null).text).toMatch(/does no mapping/);
    expect(emptyWords(true, true, undefined, null).text).toMatch(/recording/);
  });

  test("yet", () => {
    expect(emptyWords(true, false, row({ class: "SLAM" }), null).text).toMatch(/Waiting for the first map/);
    expect(emptyWords(false, false, undefined, null).more).toMatch(/does not answer/);
  });
});

describe("a goal that was given up", () => {
  const place = { x: 3.4, y: 5, theta: null };
  const reason = "zones that the robot keeps out of are in the way: “Deliveries”";
  const idle = going({ state: "idle", goal: null, given_up: { stamp: 9, goal: place, reason } });

  test("stays shown with its reason, however long ago", () => {
    expect(wayWords(idle, null, [row({})], 5000)).toEqual({
      tone: "bad",
      text: "Gave up on (3.4, 5.0)",
      more: "Zones that the robot keeps out of are in the way: “Deliveries”.",
      over: true,
    });
  });

  test("gives way to the next goal, and is shown without a reason, too", () => {
    expect(wayWords(idle, goalOf([desire({})]), [row({})])!.text).toBe("Setting out for (3.0, 4.0)…");
    const bare = { ...idle, given_up: { stamp: 9, goal: place, reason: "" } };
    expect(wayWords(bare, null, [row({})])!.more).toBe("It cannot be reached.");
  });
});

describe("what the keys do on the map", () => {
  const tools = (some: Partial<Tools>): Tools => ({ ...AT_REST, ...some });
  const cursor = { x: 1, y: 1 };

  test("is shown while the cursor has the keys", () => {
    expect(hintWords(tools({}), true)).toBe("");
    expect(hintWords(tools({ tool: "goal" }), true)).toMatch(/^Press on the goal/);
    expect(hintWords(tools({ cursor }), true)).toMatch(/^Arrows move the cursor, Enter puts a goal there/);
    expect(hintWords(tools({ cursor, tool: "pose" }), true)).toMatch(/Enter puts the robot there/);
    expect(hintWords(tools({ cursor, tool: "keep_out", corners: [cursor] }), true)).toMatch(/⌫ removes the last one/);
  });

  test("never advises Escape where that would stop the robot", () => {
    expect(hintWords(tools({ cursor }), true), "no tool is in use").not.toContain("Esc");
    const act = { kind: "aim", place: cursor, heading: null, by: "keys" } as const;
    for (const some of [
      { cursor, tool: "goal", act },
      { cursor, tool: "goal" },
      { cursor, tool: "slow" },
    ] as const) {
      expect(hintWords(tools(some), true)).toContain("Esc");
      expect(hintWords(tools(some), false)).not.toContain("Esc");
    }
  });
});
