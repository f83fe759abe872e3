import { afterEach, expect, test, vi } from "vitest";
import { sceneAddress } from "./sceneAddress";

const OWN = "http://127.0.0.1:8080/viser/";
const APART = "http://127.0.0.1:8081/viser/";
const rest = (url: string | null) => ({ scene: async () => ({ url }) });

afterEach(() => void vi.unstubAllGlobals());

function answering(answer: () => Promise<unknown>) {
  const asked = vi.fn(answer);
  vi.stubGlobal("fetch", asked);
  return asked;
}

test("the view comes from its own port where that answers", async () => {
  const asked = answering(async () => ({ ok: true }));
  expect(await sceneAddress(rest(APART), OWN, true)).toBe(APART);
  expect(String(asked.mock.calls.at(0)?.at(0 as never))).toBe("http://127.0.0.1:8081/viser/health");
});

test("from ours where it is out of reach, refuses, or is not known", async () => {
  answering(async () => Promise.reject(new TypeError("Failed to fetch")));
  expect(await sceneAddress(rest(APART), OWN, true)).toBe(OWN);
  answering(async () => ({ ok: false }));
  expect(await sceneAddress(rest(APART), OWN, true)).toBe(OWN);
  const asked = answering(async () => ({ ok: true }));
  expect(await sceneAddress(rest(null), OWN, true)).toBe(OWN);
  expect(await sceneAddress({ scene: () => Promise.reject(new Error("503")) }, OWN, true)).toBe(OWN);
  expect(asked).not.toHaveBeenCalled();
});

test("without a secure context a second port would be no use, and is not asked", async () => {
  const asked = answering(async () => ({ ok: true }));
  expect(await sceneAddress(rest(APART), OWN, false)).toBe(OWN);
  expect(asked).not.toHaveBeenCalled();
});
