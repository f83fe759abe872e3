import { expect, test } from "vitest";
import { feelingWords, shownWords } from "./Feelings";

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

test("the emotion that shows says where", () => {
  const shown = { emotion: "anger", strength: 0.5, desire: "d-1" } as const;
  expect(shownWords("anger", shown)).toBe("Face and voice show it.");
  expect(shownWords("anger", { ...shown, desire: "" })).toBe("The voice shows it.");
  expect(shownWords("joy", shown)).toBe("");
  expect(shownWords("joy", null)).toBe("");
});
