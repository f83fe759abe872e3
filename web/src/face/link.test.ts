import { expect, it } from "vitest";
import { linkOf, OLD_S } from "./link";

it("is live while the face is of now", () => {
  expect(linkOf(true, 100, null)).toBe("live");
  expect(linkOf(true, 100, 100 + OLD_S)).toBe("live");
  expect(linkOf(true, 100, 90)).toBe("live"); // a recording went back
});

it("is lost without a connection, without a face, and with an old one", () => {
  expect(linkOf(false, 100, 100)).toBe("lost");
  expect(linkOf(true, null, 100)).toBe("lost");
  expect(linkOf(true, 100, 100.1 + OLD_S)).toBe("lost");
});
