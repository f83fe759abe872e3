/** Persons with their numbers, filled while they speak; faint while they are lost. */

import { t } from "../i18n";
import type { Person } from "../protocol/types";
import { drawNamedPerson } from "./drawMarks";
import { layer } from "./layer";

export const personsLayer = layer({
  type: "persons",
  draw: (context, { persons }, onScreen) => {
    for (const person of persons) {
      const [x, y] = person.p_OP;
      const place = person.state === "tentative" ? null : onScreen({ x, y });
      if (place) drawNamedPerson(context, place, nameOf(person), person);
    }
  },
});

/** "Person 3", or "Person ?" while it is not known which. */
export function nameOf({ person }: Pick<Person, "person">): string {
  return t("Person {track}", { track: person ?? "?" });
}
