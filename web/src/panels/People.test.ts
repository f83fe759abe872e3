import { expect, test } from "vitest";
import type { RobotEvent } from "../protocol/types";
import { inTheDark } from "./People";

const event = (id: number, subject: string, camera: string): RobotEvent => ({
  id,
  stamp: id,
  kind: "percept",
  subject,
  text: "",
  data: { kind: subject.split(".")[0], subject: camera },
});

test("A camera is in the dark from dark.appears to its own dark.leaves", () => {
  const events = [
    event(1, "face.appears", "3"),
    event(2, "dark.appears", "kinect"),
    event(3, "dark.appears", "panorama"),
  ];
  expect(inTheDark(events)).toEqual(["kinect", "panorama"]);
  expect(inTheDark([...events, event(4, "dark.leaves", "panorama")])).toEqual(["kinect"]);
  expect(inTheDark([])).toEqual([]);
});
