import { describe, expect, it } from "vitest";
import type { Desire, LaneRow } from "../protocol/types";
import type { Message } from "../state/latest";
import { heardDetails, heardText, listening } from "./heard";

const HEARD: Message<"heard_words"> = {
  type: "heard_words",
  stamp: 100,
  text: "yes",
  unsure: false,
  confidence: 0.954,
  likeliest: "yes",
  direction: [1, 1, 0],
  words: ["yes", "no"],
  language: "en",
};

const DESIRE: Desire = {
  id: "d-1",
  class: "ListenForWords",
  intensity: 5,
  utility: 4,
  security: false,
  params: { words: "yes, come here ,no", language: "en" },
  source: { kind: "motivation", name: "Ask", rule: "", event: "", applied: null, motive: null },
  created: 90,
  expires: 110,
  modulation: null,
};

const ROW: LaneRow = {
  class: "ListenForWords",
  intensity: 5,
  utility: 4,
  rate: 1,
  divisor: 1,
  divisors: {},
  state: "fulfilled",
  text: "",
};

const desires = (...list: Desire[]): Message<"desires"> => ({
  type: "desires",
  stamp: 90,
  desires: list,
  exploited: [],
  accomplishments: [],
  ended: [],
  progress: [],
});
const CHOSEN = { desires: { ListenForWords: "d-1" } };

describe("listening", () => {
  it("is for the words of the strongest desire", () => {
    const other = { ...DESIRE, id: "d-2", params: { words: "left", language: "en" } };
    expect(listening(desires(other, DESIRE), CHOSEN, [ROW])).toEqual({
      words: ["yes", "come here", "no"],
      language: "en",
      reason: "",
    });
  });

  it("says why attention does not let the robot listen", () => {
    const closed: LaneRow = { ...ROW, divisor: null, state: "unfulfilled", text: "unfulfilled: needs 2 % cpu" };
    expect(listening(desires(DESIRE), CHOSEN, [closed])?.reason).toMatch(/^Needs 2 % CPU/);
  });

  it("is for nothing without such a desire, after it, or where it is inhibited", () => {
    expect(listening(null, null, [])).toBeNull();
    expect(listening(desires(DESIRE), { desires: {} }, [ROW])).toBeNull();
    expect(listening(desires(), CHOSEN, [ROW])).toBeNull();
    expect(listening(desires({ ...DESIRE, utility: 0 }), CHOSEN, [ROW])).toBeNull();
  });
});

describe("what was heard", () => {
  it("is the word, where it came from, how sure that is, and when", () => {
    expect(heardText(HEARD)).toBe("yes");
    expect(heardDetails(HEARD, 104)).toBe("45° left, 95 % sure, 4 s ago");
    expect(heardDetails(HEARD, null)).toBe("45° left, 95 % sure");
  });

  it("is never a guess", () => {
    expect(heardText({ ...HEARD, text: "", unsure: true })).toBe("not understood, perhaps yes");
    expect(heardText({ ...HEARD, text: "", unsure: true, likeliest: "" })).toBe("not understood");
  });
});
