import { expect, test } from "vitest";
import type { RobotEvent } from "../protocol/types";
import { noticed } from "./People";

const event = (id: number, name: string, subject: string): RobotEvent => {
  const kind = name.split(".")[0];
  return {
    id,
    stamp: id,
    kind: "percept",
    subject: name,
    text: "",
    data: { kind, subject, label: `${kind} ${subject}` },
  };
};

test("A percept is listed from its appearing to its own leaving, whatever its kind", () => {
  const events = [
    event(1, "dark.appears", "kinect"),
    event(2, "dark.appears", "panorama"),
    event(3, "smoke.appears", ""),
  ];
  expect(noticed(events)).toEqual(["dark kinect", "dark panorama", "smoke "]);
  expect(noticed([...events, event(4, "dark.leaves", "panorama"), event(5, "smoke.changes", "")])).toEqual([
    "dark kinect",
    "smoke ",
  ]);
  expect(noticed([])).toEqual([]);
});

test("What is drawn by itself is not listed again", () => {
  expect(noticed(["face", "voice", "noise", "code"].map((kind, id) => event(id, `${kind}.appears`, "3")))).toEqual([]);
});
