import { expect, test } from "vitest";
import { Latest } from "./latest";

const ZONES = { type: "zones", zones: [] } as const;

test("the newest message of a type is kept, whether or not it was asked for before", () => {
  const latest = new Latest();
  latest.put({ type: "desires", stamp: 1, desires: [], exploited: [], accomplishments: [], ended: [], progress: [] });
  const zones = latest.of("zones");
  expect(zones.value).toBeNull();
  const newest = { ...ZONES, zones: [] };
  latest.put(ZONES as never);
  latest.put(newest);
  expect(zones.value).toBe(newest);
  expect(latest.of("desires").value?.desires).toEqual([]);
});

test("what does not come again on a new connection is dropped, the rest never blinks", () => {
  const latest = new Latest();
  latest.put({ type: "desires", stamp: 1, desires: [], exploited: [], accomplishments: [], ended: [], progress: [] });
  latest.put({ type: "zones", zones: [] });
  const seen: unknown[] = [];
  const end = latest.of("desires").subscribe((message) => void seen.push(message));
  latest.outdate();
  expect(latest.of("zones").value).not.toBeNull();
  latest.put({ type: "desires", stamp: 1, desires: [], exploited: [], accomplishments: [], ended: [], progress: [] });
  latest.dropOutdated();
  expect(latest.of("zones").value).toBeNull();
  expect(seen).toHaveLength(2);
  expect(seen).not.toContain(null);
  latest.dropOutdated();
  expect(latest.of("desires").value).not.toBeNull();
  end();
});
