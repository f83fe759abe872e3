import { expect, test } from "vitest";
import type { Intention, SelectedStrategy } from "../protocol/types";
import {
  bodyOf,
  dearest,
  deedsOf,
  differences,
  isNothing,
  NOTHING,
  supposedHeadline,
  withCost,
  withValue,
} from "./supposition";

const strategy = (of: string, utility: number, phi: number): SelectedStrategy => ({
  name: `${of}-${phi}`,
  class: of,
  utility,
  filters: { [`${of}.images`]: phi },
  costs: { cpu: 40 / phi },
});

function intention(given: Partial<Intention>): Intention {
  return { strategies: [], reasons: {}, asked: {}, desires: {}, use: {}, ...given } as unknown as Intention;
}

const reason = (state: string, utility: number, best: number) =>
  ({ state, utility, best }) as Intention["reasons"][string];

const now = intention({
  strategies: [strategy("LocateFaces", 4, 2), strategy("FindQRCodes", 8, 1)],
  reasons: { LocateFaces: reason("degraded", 4, 8), FindQRCodes: reason("fulfilled", 8, 8) },
  asked: { LocateFaces: { intensity: 5, utility: 2, security: true, modulation: null } },
  desires: { LocateFaces: "d-1", FindQRCodes: "d-2" },
});

test("a value that is what there is, is nothing supposed", () => {
  const one = withValue(NOTHING, "capacities", "cpu", 60, 100);
  expect(isNothing(one)).toBe(false);
  expect(isNothing(withValue(one, "capacities", "cpu", 100, 100))).toBe(true);
  const dear = withCost(NOTHING, "slam-1", "cpu", 3, 1);
  expect(dear.costs).toEqual({ "slam-1": { cpu: 3 } });
  expect(isNothing(withCost(dear, "slam-1", "cpu", 1, 1))).toBe(true);
});

test("a desire keeps what else it asks for, one that is new asks for any utility, none is null", () => {
  const supposed = { ...NOTHING, desires: { LocateFaces: 7, SLAM: 3, FindQRCodes: 0 } };
  expect(bodyOf(supposed, now).desires).toEqual({
    LocateFaces: { intensity: 7, utility: 2, security: true },
    SLAM: { intensity: 3, utility: 1, security: false },
    FindQRCodes: null,
  });
});

test("classes that lose come first, those that stay as they are do not come", () => {
  const then = intention({
    strategies: [strategy("LocateFaces", 8, 1), strategy("FindQRCodes", 4, 2), strategy("SLAM", 8, 1)],
    reasons: {
      LocateFaces: reason("fulfilled", 8, 8),
      FindQRCodes: reason("degraded", 4, 8),
      DetectNoises: reason("unfulfilled", 0, 8),
    },
  });
  const found = differences(now, then);
  expect(found.map(({ name, better }) => [name, better])).toEqual([
    ["FindQRCodes", false],
    ["DetectNoises", false],
    ["LocateFaces", true],
    ["SLAM", true],
  ]);
  expect(found[0]!.before).toBe("fulfilled, camera: all");
  expect(found[0]!.after).toBe("50 % of its best, camera: every second picture");
  expect(found[1]!.before).toBe("not desired");
  expect(found[3]!.after).toContain("needed by another");
  expect(differences(now, now)).toEqual([]);
});

test("what is applied: budgets and desires, never costs", () => {
  const supposed = {
    desires: { LocateFaces: 7, SLAM: 3, FindQRCodes: 0 },
    costs: { "slam-1": { cpu: 3 } },
    capacities: { cpu: 60 },
  };
  expect(deedsOf(supposed, now).map(({ kind, name, value }) => `${kind} ${name} ${value}`)).toEqual([
    "capacity cpu 60",
    "intensity LocateFaces 7",
    "add SLAM 3",
    "remove FindQRCodes 0",
  ]);
});

test("the dearest resource is that of which the greatest share of the budget goes", () => {
  const use = { cpu: { used: 0, capacity: 100, unit: "%" }, link: { used: 0, capacity: 4, unit: "Mbit/s" } };
  expect(dearest({ cpu: 20, link: 2 }, use)).toBe("link");
  expect(dearest({ cpu: 0 }, use)).toBe(null);
});

test("what would be given up is said as what would be, not as what is", () => {
  expect(supposedHeadline({})).toContain("Nothing would be desired");
  expect(supposedHeadline({ SLAM: reason("fulfilled", 8, 8) })).toContain("would get all it can use");
  const reasons = {
    SLAM: reason("unfulfilled", 0, 8),
    LocateFaces: reason("degraded", 4, 8),
    LocateVoices: reason("degraded", 2, 8),
  };
  expect(supposedHeadline(reasons)).toBe("The robot would give up SLAM, give less to Locate voices and Locate faces.");
});
