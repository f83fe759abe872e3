import { expect, test } from "vitest";
import type { TourProblemReport } from "../protocol/types";
import { problemsAt, problemsOfTour, worst } from "./tourProblems";

const at = (field: string, severity: TourProblemReport["severity"] = "error"): TourProblemReport => ({
  field,
  message: field,
  severity,
});
const fields = (problems: TourProblemReport[]) => problems.map(({ field }) => field);

test("each problem is shown at the value that it is about, and once", () => {
  const all = ["stops.1.place", "stops.1.do.0.say.fr", "stops.10.place", "map", "stops", "greeting.do.0.say"].map(
    (one) => at(one),
  );
  expect(fields(problemsAt(all, "stops.1.place"))).toEqual(["stops.1.place"]);
  expect(fields(problemsAt(all, "stops.1"))).toEqual(["stops.1.place", "stops.1.do.0.say.fr"]);
  expect(fields(problemsAt(all, "stops.1", ["stops.1.do"]))).toEqual(["stops.1.place"]);
  expect(fields(problemsOfTour(all))).toEqual(["map", "stops"]);
  expect(fields(problemsOfTour(all, ["map"]))).toEqual(["stops"]);
});

test("the worst of them counts", () => {
  expect(worst([])).toBeNull();
  expect(worst([at("a", "warning"), at("b", "mistake"), at("c")])).toBe("mistake");
});
