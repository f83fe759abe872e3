/** Which of a tour's problems are shown where; pure. */

import type { FieldError } from "../protocol/problem";
import type { TourProblemReport } from "../protocol/types";

/** Problems that a refusal names: the tour is not kept as long as they are there. */
export function mistakes(errors: readonly FieldError[]): TourProblemReport[] {
  return errors.map(({ field, message }) => ({ field, message, severity: "mistake" }));
}

/** The problems of the value at `path`, as `stops.0.place`, and of all in it but for what is at one of `elsewhere`. */
export function problemsAt(
  problems: readonly TourProblemReport[],
  path: string,
  elsewhere: readonly string[] = [],
): TourProblemReport[] {
  return problems.filter(({ field }) => isIn(field, path) && !elsewhere.some((other) => isIn(field, other)));
}

/** What is about no stop, the greeting or the farewell, nor at one of `elsewhere`. */
export function problemsOfTour(
  problems: readonly TourProblemReport[],
  elsewhere: readonly string[] = [],
): TourProblemReport[] {
  const others = ["greeting", "farewell", ...elsewhere];
  return problems.filter(({ field }) => !/^stops\.\d/.test(field) && !others.some((other) => isIn(field, other)));
}

/** The worst of them; null: there is none. */
export function worst(problems: readonly TourProblemReport[]): TourProblemReport["severity"] | null {
  const order = ["mistake", "error", "warning"] as const;
  return order.find((severity) => problems.some((problem) => problem.severity === severity)) ?? null;
}

function isIn(field: string, path: string): boolean {
  return field === path || field.startsWith(`${path}.`);
}
