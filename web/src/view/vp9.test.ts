import { expect, test } from "vitest";
import { vp9Problem } from "./vp9";

const decoder = (isConfigSupported: () => Promise<unknown>) =>
  ({ isConfigSupported }) as unknown as typeof VideoDecoder;

test("a page that decodes VP9 says so", async () => {
  expect(
    await vp9Problem(
      true,
      decoder(async () => ({ supported: true })),
    ),
  ).toBe("");
});

test("why a page shows none, in words", async () => {
  expect(await vp9Problem(false, undefined)).toContain("https");
  expect(await vp9Problem(true, undefined)).toContain("WebCodecs");
  const none = decoder(async () => ({ supported: false }));
  expect(await vp9Problem(true, none)).toBe("this browser does not decode VP9");
  const broken = decoder(async () => {
    throw new TypeError("what?");
  });
  expect(await vp9Problem(true, broken)).toBe("this browser does not decode VP9 (what?)");
});
