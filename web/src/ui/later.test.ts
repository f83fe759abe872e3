import { h } from "preact";
import { expect, test, vi } from "vitest";
import { later } from "./later";
import { drawn } from "./page.fixture";

test("a part that does not load says so, and is asked for again", async () => {
  const load = vi.fn<() => Promise<(props: { name: string }) => string>>();
  load.mockRejectedValueOnce(new Error("offline")).mockResolvedValue(({ name }) => `the part of ${name}`);
  const Part = later(load);
  const page = drawn(h(Part, { name: "tours" }), {});
  await vi.waitFor(() => page.one("not-loaded"));
  await page.press("load-again");
  await vi.waitFor(() => expect(page.words()).toBe("the part of tours"));
  expect(load).toHaveBeenCalledTimes(2);
});
