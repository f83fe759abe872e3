import { expect, test } from "vitest";
import {
  chosen,
  DAYS,
  type Day,
  linesOf,
  NEW_SLOT,
  numberOf,
  numberShown,
  slotWords,
  timesOf,
  wrongOf,
} from "./tourRules";

const days = DAYS.map(([day]) => day);

test("days of a schedule are in the order of the week, each once", () => {
  expect(chosen<Day>(days, ["thu"], "tue", true)).toEqual(["tue", "thu"]);
  expect(chosen<Day>(days, ["tue", "thu"], "tue", true)).toEqual(["tue", "thu"]);
  expect(chosen<Day>(days, ["tue", "thu"], "thu", false)).toEqual(["tue"]);
});

test("times are read as people write them", () => {
  expect(timesOf("15:30, 14:00")).toEqual(["14:00", "15:30"]);
  expect(timesOf("9:30;9.30 14h 8h05 16")).toEqual(["08:05", "09:30", "14:00", "16:00"]);
  expect(timesOf(" ")).toEqual([]);
});

test("what is no time is left to the robot, which says so", () => {
  expect(timesOf("noon 25:00")).toEqual(["25:00", "noon"]);
});

test("a schedule is said in a line", () => {
  expect(slotWords({ days: ["tue", "thu"], times: ["14:00", "15:30"] })).toBe("Tue, Thu at 14:00, 15:30");
  expect(slotWords({ days: [], times: [] })).toBe("no day at no time");
  expect(slotWords(NEW_SLOT)).toBe("Mon, Tue, Wed, Thu, Fri at 10:00");
});

test("a share is typed and shown in percent, without the digits of binary numbers", () => {
  expect(numberShown(0.29, 100)).toBe("29");
  expect(numberOf("29", 100)).toBe(0.29);
  expect(numberOf("28,5", 100)).toBe(0.285);
  expect(numberShown(0.2, 180 / Math.PI)).toBe("11.46");
  expect(numberShown(1234.5678)).toBe("1234.5678");
  expect(numberShown(null)).toBe("");
  expect(numberOf(" ")).toBeNull();
  expect(numberOf("−2.5")).toBe(-2.5);
  expect(numberOf("much")).toBeNaN();
});

test("what cannot be a value is refused where it is typed, in the unit that is shown", () => {
  expect(wrongOf("40", [0, 100])).toBe("");
  expect(wrongOf("", [0, 100])).toBe("");
  expect(wrongOf("300", [0, 100])).toBe("Not kept: should be 0 to 100, not “300”.");
  expect(wrongOf("much", [0, 100])).toMatch("0 to 100");
  expect(wrongOf("much")).toBe("Not kept: should be a number, not “much”.");
  expect(wrongOf("-3")).toBe("");
});

test("texts of codes are one a line", () => {
  expect(linesOf("HBBA:SAY/EN/HELLO\n\n tour:desk ")).toEqual(["HBBA:SAY/EN/HELLO", "tour:desk"]);
});
