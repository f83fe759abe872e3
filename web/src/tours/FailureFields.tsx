/** What the robot does where a stop cannot be reached, or a step fails: the tour's rules, or a stop's own. */

import { type Text, t } from "../i18n";
import type { FailureExceptions, FailureRules } from "../protocol/types";
import { Choice, NumberField } from "./parts";

const REACH = [
  ["skip", "goes on to the next"],
  ["present_from_here", "presents it from where it is"],
  ["end", "ends the tour"],
] as const;
const PRESENT = [
  ["continue", "goes on with the next step"],
  ["skip", "leaves the rest of the stop out"],
  ["end", "ends the tour"],
] as const;

type Own<Rules> = { [Key in keyof Rules]: Rules[Key] | null };
type Reach = FailureRules["reach"];
type Present = FailureRules["present"];

interface Props<R, P> {
  /** As `stops.0.on_failure`. */
  path: string;
  onReach: (change: Partial<R>) => void;
  onPresent: (change: Partial<P>) => void;
}

/** The tour's: none can be left out. */
export function FailureFields(props: Props<Reach, Present> & { rules: FailureRules }) {
  return (
    <Fields
      {...props}
      usual={null}
      onReach={(change) => props.onReach(given<Reach>(change))}
      onPresent={(change) => props.onPresent(given<Present>(change))}
    />
  );
}

/** A stop's own: what is left out is as `usual` says. */
export function OwnFailureFields(
  props: Props<Own<Reach>, Own<Present>> & { rules: FailureExceptions; usual: FailureRules },
) {
  return <Fields {...props} />;
}

/** `change` without what is null. */
function given<Rules extends object>(change: Partial<Own<Rules>>): Partial<Rules> {
  return Object.fromEntries(Object.entries(change).filter(([, value]) => value !== null)) as Partial<Rules>;
}

function Fields(
  props: Props<Own<Reach>, Own<Present>> & { rules: FailureExceptions | FailureRules; usual: FailureRules | null },
) {
  const { path, usual } = props;
  const { reach, present } = props.rules;
  return (
    <>
      <fieldset class="tour-rules">
        <legend>{t("A stop cannot be reached")}</legend>
        <div class="form-row two">
          <NumberField
            label={t("Tries again (times)")}
            value={reach.retry}
            path={`${path}.reach.retry`}
            testid="reach-retry"
            {...asUsual(usual?.reach.retry)}
            onDone={(retry) => props.onReach({ retry })}
          />
          <NumberField
            label={t("Then asks you for (s)")}
            value={reach.ask_s}
            path={`${path}.reach.ask_s`}
            testid="reach-ask"
            {...asUsual(usual?.reach.ask_s)}
            onDone={(ask_s) => props.onReach({ ask_s })}
          />
        </div>
        <Choice
          label={t("Without an answer, it")}
          value={reach.then ?? ""}
          path={`${path}.reach.then`}
          testid="reach-then"
          options={withUsual(REACH, usual?.reach.then)}
          onChange={(then) => props.onReach({ then: then || null })}
        />
      </fieldset>
      <fieldset class="tour-rules">
        <legend>{t("A step fails")}</legend>
        <NumberField
          label={t("Tries again (times)")}
          value={present.retry}
          path={`${path}.present.retry`}
          testid="present-retry"
          {...asUsual(usual?.present.retry)}
          onDone={(retry) => props.onPresent({ retry })}
        />
        <Choice
          label={t("Then it")}
          value={present.then ?? ""}
          path={`${path}.present.then`}
          testid="present-then"
          options={withUsual(PRESENT, usual?.present.then)}
          onChange={(then) => props.onPresent({ then: then || null })}
        />
      </fieldset>
    </>
  );
}

function asUsual(value: number | undefined): { placeholder?: string } {
  return value === undefined ? {} : { placeholder: t("{value}, as the tour", { value }) };
}

function withUsual<T extends string>(
  options: readonly (readonly [T, Text])[],
  usual: T | undefined,
): readonly (readonly [T | "", string])[] {
  const shown = options.map(([value, words]): readonly [T | "", string] => [value, t(words)]);
  const words = shown.find(([value]) => value === usual)?.[1];
  return words === undefined ? shown : [["", t("{words} (as the tour)", { words })], ...shown];
}
