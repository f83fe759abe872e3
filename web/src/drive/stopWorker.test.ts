import { expect, test } from "vitest";
import { GIVE_UP_MS, orderStop } from "./stopWorker";

function robot(...statuses: (number | Error)[]) {
  let now = 0;
  const asked: number[] = [];
  const ordered = orderStop(
    async () => {
      asked.push(now);
      const status = statuses[Math.min(asked.length, statuses.length) - 1]!;
      if (typeof status === "number") return status;
      throw status;
    },
    () => now,
    async (ms) => {
      now += ms;
    },
  );
  return { asked, ordered };
}

test("it is asked for again until the robot answers that it is latched", async () => {
  const { asked, ordered } = robot(new Error("no connection"), 503, 504, 200);
  expect(await ordered).toBe(true);
  expect(asked).toHaveLength(4);
});

test("what is refused stays refused, and a robot out of reach is not asked for ever", async () => {
  const refused = robot(409);
  expect(await refused.ordered).toBe(false);
  expect(refused.asked).toHaveLength(1);
  const gone = robot(new Error("no connection"));
  expect(await gone.ordered).toBe(false);
  expect(gone.asked.at(-1)!).toBeLessThanOrEqual(GIVE_UP_MS + 200);
});
