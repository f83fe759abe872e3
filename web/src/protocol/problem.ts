/** Refusals of the robot (RFC 9457). */

import { type FieldFault, faultWords, saysRule, t } from "../i18n";
import { sentence } from "../ui/format";

export interface FieldError {
  field: string;
  message: string;
}

/** A refusal, in words for people; `status` 0: no answer. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    readonly title: string,
    readonly detail: string,
    readonly errors: FieldError[] = [],
  ) {
    super(detail || title);
  }
}

export async function readProblem(response: Response): Promise<Problem> {
  const body = (await response.json().catch(() => null)) as Partial<Problem> | null;
  const title =
    typeof body?.title === "string" ? body.title : t("The robot answered {status}", { status: response.status });
  const said = typeof body?.detail === "string" ? body.detail : "";
  const faults: (FieldError & FieldFault)[] = Array.isArray(body?.errors)
    ? body.errors.filter((e) => e && typeof e.message === "string")
    : [];
  const errors = faults.map((fault) => ({ field: fault.field, message: faultWords(fault) }));
  // Where a rule says each of them, so it does all of them: the detail lists no more than these.
  const detail =
    faults.length > 0 && faults.every(saysRule)
      ? errors.map(({ field, message }) => t("{what}: {which}", { what: field, which: message })).join("; ")
      : said;
  return new Problem(response.status, title, detail, errors);
}

/** A refusal in one line: why, and what is wrong with each field that the reason does not name. */
export function inWords(error: unknown): string {
  if (!(error instanceof Problem)) return String(error);
  const why = error.detail || error.title;
  const fields = error.errors.map((each) => each.message).filter((message) => !why.includes(message));
  return [why, ...fields].map(sentence).join(" ");
}
