import { expect, test } from "vitest";
import { driverName, driverWords } from "./driver";

const MODULES = [{ name: "PlanAndFollowPath", title: "Plan and follow a path" }];
const ann = (holds: boolean) => ({ driver: { operator: "Ann", mine: false, holds }, exploited: null });

test("who lets go of the key drives no more, though the wheel is still theirs", () => {
  const mine = { driver: { operator: "Ann", mine: true, holds: true }, exploited: "Teleop" };
  expect(driverName(mine, MODULES)).toBe("You");
  expect(driverName({ driver: { ...mine.driver, holds: false }, exploited: null }, MODULES)).toBe("Nobody");
  expect(driverName({ ...mine, driver: { ...mine.driver, holds: false } }, MODULES)).toBe("Nobody");
  expect(driverWords({ driver: { ...mine.driver, holds: false }, exploited: null }, MODULES)).toBe(
    "Who drives the robot: nobody. You have control.",
  );
});

test("another's hand is named, and who has the wheel", () => {
  expect(driverName(ann(true), MODULES)).toBe("Ann");
  expect(driverName(ann(false), MODULES)).toBe("Nobody");
  expect(driverWords(ann(false), MODULES)).toBe("Who drives the robot: nobody. Ann has control.");
});

test("a behavior goes by its title, and drives while a hand only keeps the wheel", () => {
  expect(driverName({ driver: null, exploited: "PlanAndFollowPath" }, MODULES)).toBe("Plan and follow a path");
  expect(driverName({ ...ann(false), exploited: "PlanAndFollowPath" }, MODULES)).toBe("Plan and follow a path");
  expect(driverName(null, MODULES)).toBe("–");
});
