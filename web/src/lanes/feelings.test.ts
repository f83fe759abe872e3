import { expect, test } from "vitest";
import { feelingWords } from "./Feelings";

test("an emotion says how strong it is, and whose neglect has fed it", () => {
  const sources = [
    { class: "GoTo", share: 0.5, neglected: true },
    { class: "Dock", share: 0.25, neglected: false },
  ];
  expect(feelingWords({ emotion: "anger", intensity: 0.75, sources })).toBe(
    "anger 0.75\nGo to 0.5 (neglected)\nDock 0.25",
  );
  expect(feelingWords({ emotion: "fear", intensity: 0, sources: [] })).toBe("fear 0");
});
