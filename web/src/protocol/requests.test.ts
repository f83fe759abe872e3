import { afterEach, expect, test, vi } from "vitest";
import { Problem } from "./problem";
import { Requests } from "./requests";

function robot(answer: () => Response) {
  const fetched = vi.fn(async (_: string, __: RequestInit) => answer());
  vi.stubGlobal("fetch", fetched);
  return {
    requests: new Requests(() => "Chloé"),
    sent: () => ({ url: fetched.mock.calls.at(-1)![0], ...fetched.mock.calls.at(-1)![1] }),
  };
}

afterEach(() => void vi.unstubAllGlobals());

test("JSON goes out and comes in, under a name that a header can carry", async () => {
  const { requests, sent } = robot(() => new Response('{"id": "d-1"}'));
  expect(await requests.ask("POST", "/desires", { class: "Say" }, { "Idempotency-Key": "k" })).toEqual({ id: "d-1" });
  expect(sent()).toMatchObject({
    url: "./api/v1/desires",
    method: "POST",
    body: '{"class":"Say"}',
    headers: {
      Accept: "application/json",
      "Content-Type": "application/json",
      "X-HBBA-Operator": "Chlo%C3%A9",
      "Idempotency-Key": "k",
    },
  });
});

test("a request without a body has none, and an answer without one is null", async () => {
  const { requests, sent } = robot(() => new Response(null, { status: 204 }));
  expect(await requests.ask("DELETE", "/goal")).toBeNull();
  expect(sent()).not.toHaveProperty("body");
  expect(sent().headers).not.toHaveProperty("Content-Type");
});

test("a file is sent as it is", async () => {
  const { requests, sent } = robot(() => new Response("{}"));
  const file = new Blob(["id: lab"]);
  await requests.ask("POST", "/tours/import", file, { "Content-Type": "application/octet-stream" });
  expect(sent()).toMatchObject({ body: file, headers: { "Content-Type": "application/octet-stream" } });
});

test("a refusal is the robot's, and no answer is one without a status", async () => {
  const refused = robot(() => new Response('{"title": "Too fast", "detail": "at most 1 m/s"}', { status: 422 }));
  await expect(refused.requests.ask("PUT", "/goal", {})).rejects.toMatchObject({
    status: 422,
    detail: "at most 1 m/s",
  });
  const { requests } = robot(() => {
    throw new TypeError("fetch failed");
  });
  const problem = await requests.ask("GET", "/maps").catch((error) => error);
  expect(problem).toBeInstanceOf(Problem);
  expect(problem).toMatchObject({ status: 0, title: "No answer" });
});
