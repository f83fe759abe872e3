import { expect, test } from "vitest";
import type { Hello, LaneRow } from "../protocol/types";
import { perceives, whyClosed } from "./whyClosed";

const hello = { channels: { camera: true, panorama: true }, classes: [] } as unknown as Hello;
const row = (name: string, divisor: number | null, text = ""): LaneRow => ({
  class: name,
  intensity: 1,
  utility: 1,
  rate: null,
  divisor,
  divisors: {},
  state: divisor === null ? "unfulfilled" : "fulfilled",
  text,
});

test("nothing is closed where all is open", () => {
  const rows = [row("Telepresence", 1), row("LocateFaces", 2), row("LocateVoices", 1)];
  expect(whyClosed(hello, rows, false, true)).toEqual([]);
});

test("attention's own reason is shown", () => {
  const rows = [
    row("Telepresence", 1),
    row("LocateFaces", null, "unfulfilled: needs 20 % more cpu"),
    row("LocateVoices", 1),
  ];
  expect(whyClosed(hello, rows, false, true)).toEqual([
    { what: "faces", text: "Face detection is off", reason: "Needs 20 % more CPU." },
  ]);
});

test("a robot without these senses says so, and without a camera all around", () => {
  const bare = { channels: {}, classes: [] } as unknown as Hello;
  expect(whyClosed(bare, [row("Telepresence", 1)], false, false).map(({ what }) => what)).toEqual([
    "picture",
    "faces",
    "voices",
  ]);
});

test("what no strategy serves is missing, whether or not there is a desire for it", () => {
  const classes = [{ name: "LocateVoices", served: false }];
  const deaf = { ...hello, classes } as Hello;
  const rows = [
    row("Telepresence", 1),
    row("LocateFaces", 1),
    row("LocateVoices", null, "undesired: no desire for it"),
  ];
  expect(whyClosed(deaf, rows, false, true)).toEqual([
    { what: "voices", text: "This robot does not localize sounds", reason: "" },
  ]);
});

test("a fresh picture is not said to be missing, whatever attention just did", () => {
  const rows = [row("Telepresence", null), row("LocateFaces", 1), row("LocateVoices", 1)];
  expect(whyClosed(hello, rows, false, true)).toEqual([]);
  expect(whyClosed(hello, rows, false, false).map(({ what }) => what)).toEqual(["picture"]);
});

test("of a robot that cannot perceive people nothing is shown; a recording may still have some", () => {
  const kind = (served: boolean) => ({ name: "LocateVoices", served });
  const blind = (served: boolean) => ({ channels: { panorama: false }, classes: [kind(served)] }) as unknown as Hello;
  expect(perceives(blind(false))).toBe(false);
  expect(perceives(blind(true))).toBe(true);
  expect(perceives({ ...blind(false), playback: {} } as Hello)).toBe(true);
  expect(perceives(null)).toBe(true);
});
