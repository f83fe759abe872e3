import { expect, test } from "vitest";
import type { SelectedStrategy } from "../protocol/types";
import { filterWords, headline, intake, plainReason, type Reason, shortfall, sorted } from "./attentionText";

const reason = (state: Reason["state"], utility: number, best: number): Reason => ({
  state,
  utility,
  best,
  wanted: 1,
  text: "",
  alternatives: [],
  searched: true,
  remark: "",
});

test.each([
  ["FaceDetector.images", 1, "camera: all"],
  ["FaceDetector.images", 2, "camera: every second picture"],
  ["QRCodeDetector.scans", 4, "laser: every fourth scan"],
  ["VoiceLocalizer.audio", null, "sound: nothing"],
  ["QRCodeDetector.panorama", 40, "all-round camera: one picture in 40"],
  ["Theirs.rawThings", 2, "raw things: every second message"],
])("φ of %s = %s is in words %s", (port, phi, words) => {
  expect(filterWords(port, phi)).toBe(words);
});

test("what strategies take in is said once for each source", () => {
  const strategies = [
    { filters: { "A.images": 4, "A.scans": null } },
    { filters: { "B.images": 2 } },
  ] as unknown as SelectedStrategy[];
  expect(intake(strategies)).toEqual(["camera: every second picture", "laser: nothing"]);
});

test("what was given up comes first, the most missed at the top", () => {
  const { given, best } = sorted({
    FindQRCodes: reason("fulfilled", 8, 8),
    LocateFaces: reason("degraded", 4, 8),
    Say: reason("inhibited", 0, 8),
    LocateVoices: reason("unfulfilled", 0, 8),
  });
  expect(given.map(([name]) => name)).toEqual(["LocateVoices", "LocateFaces", "Say"]);
  expect(best.map(([name]) => name)).toEqual(["FindQRCodes"]);
});

test("the headline names what was given up, or that nothing was", () => {
  expect(headline({})).toContain("Nothing is desired");
  expect(headline({ FindQRCodes: reason("fulfilled", 8, 8) })).toBe("Everything that is desired gets all it can use.");
  expect(
    headline({
      LocateFaces: reason("degraded", 4, 8),
      LocateVoices: reason("unfulfilled", 0, 8),
      ClassifySounds: reason("unfulfilled", 0, 8),
    }),
  ).toBe("The robot gave up Locate voices and Classify sounds, gives less to Locate faces.");
});

test("a shortfall is a share of the best", () => {
  expect(shortfall(reason("degraded", 4, 8))).toBe("50 % of its best");
  expect(shortfall(reason("fulfilled", 8, 8))).toBe("");
});

test("the plain reason says what would bring the rest, without names of strategies", () => {
  const text = "fulfilled at 4 of 8 by locate-near-faces-1; would get 8 with 33.4 % more CPU";
  expect(plainReason({ ...reason("degraded", 4, 8), text })).toBe("would be at its best with 33.4 % more CPU");
  expect(plainReason({ ...reason("degraded", 4, 8), text: "fulfilled at 4 of 8 by locate-near-faces-1" })).toBe("");
  expect(plainReason({ ...reason("unfulfilled", 0, 8), text: "no strategy" })).toBe("no strategy");
});
