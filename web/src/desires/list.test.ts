import { expect, test } from "vitest";
import { motiveWords } from "./DesireList";

test("a motivation says of what kind it is", () => {
  expect(motiveWords("instinctive", "Recharge")).toBe("by Recharge, for what the robot itself needs");
  expect(motiveWords("rational", "Tour guide")).toBe("by Tour guide, for its task");
  expect(motiveWords("emotional", "Emotions")).toBe("by Emotions, because of a conflict or a feeling");
  expect(motiveWords(null, "Say")).toBe("by Say");
});
