import { expect, test } from "vitest";
import type { Intention } from "../protocol/types";
import { gaugesOf } from "./gauges";
import type { IntentionStep } from "./timelineOf";

const INTENTION = {
  omega: 12,
  use: {
    cpu: { used: 40, capacity: 100, unit: "%" },
    energy: { used: 70, capacity: 60, unit: "W" },
    network: { used: 0, capacity: 0, unit: "MB/s" },
  },
} as unknown as Intention;

test("Ω comes first, scaled to the greatest that was seen", () => {
  const [omega] = gaugesOf(INTENTION, 30);
  expect(omega).toMatchObject({ name: "omega", title: "Ω", figure: "12", most: 30, budget: null });
  expect(gaugesOf(INTENTION, 0.2)[0]!.most).toBe(1);
});

test("each budget is a lane in which all that is used or promised has room", () => {
  const [, cpu, energy, network] = gaugesOf(INTENTION, 30);
  expect(cpu).toMatchObject({ name: "cpu", title: "CPU", figure: "40 of 100 %", budget: 100 });
  expect(energy).toMatchObject({ title: "energy", figure: "70 of 60 W", budget: 60 });
  expect(cpu!.most).toBeGreaterThan(100);
  expect(energy!.most).toBeGreaterThan(70);
  expect(network!.most).toBe(1);
});

test("a lane shows what an intention of then used, and nothing of what it did not know", () => {
  const step = { omega: 9, use: { cpu: 25 } } as unknown as IntentionStep;
  expect(gaugesOf(INTENTION, 30).map((gauge) => gauge.value(step))).toEqual([9, 25, 0, 0]);
});
