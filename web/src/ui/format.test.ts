import { expect, test } from "vitest";
import {
  ago,
  clockSpan,
  divisor,
  divisorLines,
  left,
  millis,
  moduleTitle,
  nameAndTitle,
  number,
  reasonText,
  sentence,
  size,
  small,
  spaced,
  stateWord,
} from "./format";

test("ages are said as people say them", () => {
  expect([0.4, 12.3, 89, 200, 7200, 200_000].map(ago)).toEqual([
    "just now",
    "12 s ago",
    "89 s ago",
    "3 min ago",
    "2 h ago",
    "2 d ago",
  ]);
  expect([0.2, 29.4, 600].map(left)).toEqual(["1 s left", "30 s left", "10 min left"]);
  expect(ago(-3)).toBe("just now");
});

test("a reason by itself is a sentence", () => {
  expect(["disk full", "Disk full. ", ""].map(sentence)).toEqual(["Disk full.", "Disk full.", ""]);
});

test("sizes and lengths of recordings", () => {
  expect([0, 999, 1500, 34_234_000, 999_700_000, 12_345_000_000, null].map(size)).toEqual([
    "0 B",
    "999 B",
    "1.5 kB",
    "34 MB",
    "1 GB",
    "12.3 GB",
    "–",
  ]);
  expect([0, 5, 62.9, 3723].map((s) => clockSpan(s))).toEqual(["0:00", "0:05", "1:02", "1:02:03"]);
  expect([0.3, 5.04, 62.97].map((s) => clockSpan(s, 1))).toEqual(["0:00.3", "0:05.0", "1:02.9"]);
});

test("divisors, milliseconds and numbers", () => {
  expect([1, 2, null, undefined].map(divisor)).toEqual(["all", "1 of 2", "closed", "closed"]);
  expect([1.234, 34.6, 12_400, null].map(millis)).toEqual(["1.2", "35", "12 s", "–"]);
  expect([8, 1.25, -0.5, null].map((v) => number(v))).toEqual(["8", "1.3", "−0.5", "–"]);
});

test("costs have one decimal where needed, and little is not nothing", () => {
  expect([4, 1.5, 0.75, 0.05, 0.04, 0].map(small)).toEqual(["4", "1.5", "0.8", "0.1", "< 0.1", "0"]);
});

test("names of classes are spaced, acronyms stay", () => {
  expect(["FindQRCodes", "SLAM", "LocateFaces", "GoTo", "Teleoperation"].map(spaced)).toEqual([
    "Find QR codes",
    "SLAM",
    "Locate faces",
    "Go to",
    "Teleoperation",
  ]);
});

test("what gets as much as it wants is fulfilled, though not at its best", () => {
  expect(["fulfilled", "degraded", "unfulfilled", "needed"].map(stateWord)).toEqual([
    "fulfilled",
    "fulfilled, below its best",
    "unfulfilled",
    "needed",
  ]);
});

test("a class goes by one name, with its title beside it where that says more", () => {
  const said = (name: string, title: string) => nameAndTitle({ name, title });
  expect(said("Telepresence", "See through the robot's eyes")).toBe("Telepresence: see through the robot's eyes");
  expect(said("Map", "SLAM of the rooms")).toBe("Map: SLAM of the rooms");
  expect(said("FindQRCodes", "Find QR codes")).toBe("Find QR codes");
  expect(said("GoTo", "")).toBe("Go to");
});

test("a reason does not repeat the state that stands beside it", () => {
  expect(reasonText("unfulfilled", "unfulfilled: no room")).toBe("No room");
  expect(reasonText("fulfilled", "fulfilled at its best")).toBe("Fulfilled at its best");
  expect(reasonText("undesired", "No desire for it.")).toBe("No desire for it.");
});

test("a module is called as people call it", () => {
  const modules = [{ name: "PlanAndFollowPath", title: "Plan and follow path" }];
  expect(moduleTitle("PlanAndFollowPath", modules)).toBe("Plan and follow path");
  expect(moduleTitle("GoToward", modules)).toBe("Go toward");
});

test("what several filters let through is a line each, one alone is shown elsewhere", () => {
  expect(divisorLines({ "QR.images": 1, "QR.scans": 2, "QR.panorama": null })).toEqual([
    "QR.images all",
    "QR.scans 1 of 2",
    "QR.panorama closed",
  ]);
  expect(divisorLines({ "QR.images": 4 })).toEqual([]);
});

test("the computing time is called as everywhere on the page", () => {
  expect(reasonText("degraded", "degraded: would get 8 with 2 % more cpu")).toBe("Would get 8 with 2 % more CPU");
});
