/** One step: what the robot says, shows and does at once; only what it names has fields. */

import { type Text, t } from "../i18n";
import type { Step, TourProblemReport, Wait } from "../protocol/types";
import { useApp } from "../state/context";
import { ChevronIcon, ChevronUpIcon, CloseIcon, PlayIcon, TrashIcon } from "../ui/icons";
import { HEIGHT_M, PartFields } from "./PartFields";
import { Problems } from "./parts";
import { NO_STEP, PARTS, type Part } from "./tourEdits";
import { problemsAt } from "./tourProblems";

interface Props {
  step: Step;
  /** Of the value that it is, as `stops.2.do.0`. */
  path: string;
  languages: readonly string[];
  problems: readonly TourProblemReport[];
  /** Text of the stop's poster. */
  poster: string | null;
  onChange: (change: Partial<Step>) => void;
  /** Without: it is the only one. */
  onMove?: (by: number) => void;
  onRemove?: () => void;
}

const NAMES: Record<Part, Text> = {
  say: "Say",
  look: "Look",
  point: "Point|deed",
  show: "Show",
  gesture: "Gesture",
  expression: "Face",
  wait: "Wait",
};
const WAIT: Wait = { at_most_s: 20, words: {}, claps: null, call: false, press: null, all_left: false };

export function StepForm({ step, path, languages, problems, poster, onChange, onMove, onRemove }: Props) {
  const { tourPointing, tourTrial } = useApp();
  const parts = PARTS.filter((part) => step[part] !== null);
  const others = PARTS.filter((part) => step[part] === null);
  const drop = (part: Part) => onChange({ [part]: null });
  return (
    <li class="tour-step" data-testid="tour-step" data-path={path}>
      <div class="tour-step-head">
        <button
          type="button"
          class="button small"
          data-testid="step-try"
          title={t("The robot does it now, where it is")}
          disabled={!tourTrial.can(step, poster)}
          onClick={() => void tourTrial.step(step, languages, poster)}
        >
          <PlayIcon /> {t("Try")}
        </button>
        <span class="tour-step-actions">
          {onMove && (
            <>
              <button
                type="button"
                class="icon-button"
                aria-label={t("Earlier")}
                title={t("Earlier")}
                onClick={() => onMove(-1)}
              >
                <ChevronUpIcon />
              </button>
              <button
                type="button"
                class="icon-button"
                aria-label={t("Later")}
                title={t("Later")}
                onClick={() => onMove(1)}
              >
                <ChevronIcon />
              </button>
            </>
          )}
          {onRemove && (
            <button
              type="button"
              class="icon-button"
              aria-label={t("Remove the step")}
              title={t("Remove the step")}
              onClick={onRemove}
            >
              <TrashIcon />
            </button>
          )}
        </span>
      </div>
      {parts.map((part) => (
        <div key={part} class="tour-part" data-part={part}>
          <div class="tour-form">
            <PartFields part={part} step={step} path={path} languages={languages} onChange={onChange} />
          </div>
          {(parts.length > 1 || !onRemove) && (
            <button
              type="button"
              class="icon-button"
              aria-label={t("Remove: {part}", { part: t(NAMES[part]) })}
              title={t("Remove: {part}", { part: t(NAMES[part]) })}
              disabled={parts.length === 1}
              onClick={() => drop(part)}
            >
              <CloseIcon />
            </button>
          )}
        </div>
      ))}
      {others.length > 0 && (
        <div class="tour-adds" role="group" aria-label={t("At the same time")}>
          {others.map((part) => (
            <button
              key={part}
              type="button"
              class="button small quiet"
              data-testid={`step-add-${part}`}
              onClick={() => {
                onChange({ [part]: initial(part, languages) } as Partial<Step>);
                if (part === "point") tourPointing.choose({ path, part });
              }}
            >
              + {t(NAMES[part])}
            </button>
          ))}
        </div>
      )}
      <Problems
        problems={problemsAt(
          problems,
          path,
          parts.map((part) => `${path}.${part}`),
        )}
      />
    </li>
  );
}

/** What a part is at first: to be changed, and allowed as it is. */
export function initial(part: Part, languages: readonly string[]): Step[Part] {
  const language = languages[0] ?? "en";
  switch (part) {
    case "say":
      return { [language]: "…" };
    case "look":
      return "visitors";
    case "point":
      return [0, 0, HEIGHT_M];
    case "show":
      return { file: "media/picture.jpg", alt: { [language]: "A picture" } };
    case "gesture":
      return { class: "Wave", params: {} };
    case "expression":
      return "happy";
    case "wait":
      return WAIT;
  }
}

export function firstStep(languages: readonly string[]): Step {
  return { ...NO_STEP, say: initial("say", languages) as Step["say"] };
}
