import { expect, test } from "vitest";
import { headWords, heldWords } from "./driveText";

test("a driver reads what letting go does", () => {
  expect(heldWords("keyboard", false, false)).toBe("Driving by keyboard. Let go to stop.");
  expect(heldWords("stick", true, false)).toBe("Driving by stick, slowly. Let go to stop.");
});

test("with a goal, letting go does not stop the robot", () => {
  expect(heldWords("keyboard", false, true)).toBe("Driving by keyboard. Let go to continue to the goal.");
});

test("what the head does is said where it is not what the hand expects", () => {
  const head = (state: string, reason = "", exploited: string | null = null) => ({
    group: "head",
    state,
    reason,
    exploited,
    speed_radps: 0,
  });
  expect(headWords(null, true).text).toBe("");
  expect(headWords(head("idle"), false).text).toBe("");
  expect(headWords(head("moving", "", "HeadTeleop"), true)).toEqual({
    text: "Turning the head. Let go to hold it.",
    warns: false,
  });
  expect(headWords(head("moving", "", "LookAt"), false).text).toBe("LookAt turns the head.");
  expect(headWords(head("holding", "no fresh command for 0.3 s"), false).text).toBe("");
  expect(headWords(head("holding", "emergency stop: pressed by ann"), true)).toEqual({
    text: "The head is held still: emergency stop: pressed by ann.",
    warns: true,
  });
  expect(headWords(head("refused", "the last command was not a number"), false).text).toBe(
    "The head refused the command: the last command was not a number.",
  );
  expect(headWords(head("yielding"), false)).toEqual({ text: "The head yields.", warns: false });
});
