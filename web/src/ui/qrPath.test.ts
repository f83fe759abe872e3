import { expect, test } from "vitest";
import { codePath } from "./qrPath";

test("a rectangle for each run of black modules, within the quiet zone", () => {
  expect(codePath(["110", "001"])).toBe("M4 4h2v1h-2zM6 5h1v1h-1z");
  expect(codePath([])).toBe("");
});
