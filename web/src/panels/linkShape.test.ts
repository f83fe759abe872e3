import { expect, test } from "vitest";
import { linkChange } from "./LinkShape";

test("an empty field shapes nothing", () => {
  const fields: Record<string, string> = { delay_ms: "300", jitter_ms: " ", loss_percent: "2.5", rate_mbit: "" };
  expect(linkChange((name) => fields[name] ?? "")).toEqual({ delay_ms: 300, loss_percent: 2.5 });
});
