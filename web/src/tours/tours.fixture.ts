/** Tours for tests, as REST has them. */

import type { Stop, Tour } from "../protocol/types";
import { newStop } from "./tourEdits";

export function aTour(stops: Stop[], more: Partial<Tour> = {}): Tour {
  return {
    format: 1,
    id: "lab",
    title: { en: "The lab" },
    languages: ["en", "fr"],
    map: "ground",
    home: null,
    begin: { by: ["press"], people_min: 1, within_m: 2.5, for_s: 2 },
    schedule: [],
    battery: { begin_min: 0.4, end_below: 0.2 },
    pace: { speed: 0.8, slow_m: 2.5, wait_m: 4, give_up_s: 60, look_back_m: 5 },
    on_failure: { reach: { retry: 2, ask_s: 20, then: "skip" }, present: { retry: 0, then: "continue" } },
    greeting: { do: [], confirm: null },
    farewell: { do: [] },
    commands: { pause: {}, resume: {}, skip: {}, undo_skip: {}, repeat: {}, end: {} },
    accept: [],
    stops,
    ...more,
  };
}

export function aStop(id: string, more: Partial<Stop> = {}): Stop {
  return { ...newStop({ languages: ["en"], stops: [] }, id, id), ...more };
}
