/** Steps one after another: of a stop, the greeting, the farewell. */

import { useRef } from "preact/hooks";
import { t } from "../i18n";
import type { Step } from "../protocol/types";
import { useApp } from "../state/context";
import { PlusIcon } from "../ui/icons";
import { firstStep, StepForm } from "./StepForm";
import { stepChanged, stepMoved, withoutIdle } from "./tourEdits";
import { problemsAt } from "./tourProblems";

interface Props {
  /** Where they are in the tour, as `stops.0.do`. */
  path: string;
  steps: readonly Step[];
  /** Text of the stop's poster. */
  poster: string | null;
  onChange: (change: (steps: readonly Step[]) => Step[]) => void;
}

export function StepList({ path, steps, poster, onChange }: Props) {
  const { tours } = useApp();
  const { languages } = tours.draft.value!;
  const list = useRef<HTMLOListElement>(null);
  const add = () => {
    onChange((all) => [...all, firstStep(languages)]);
    // People who add a step write its text next.
    requestAnimationFrame(() => list.current?.querySelector<HTMLTextAreaElement>("li:last-child textarea")?.select());
  };
  return (
    <div class="tour-steps">
      <ol ref={list}>
        {steps.map((step, at) => (
          <StepForm
            key={`${path}.${at}`}
            step={step}
            path={`${path}.${at}`}
            languages={languages}
            problems={problemsAt(tours.problems.value, `${path}.${at}`)}
            poster={poster}
            onChange={(change) => onChange((all) => withoutIdle(stepChanged(all, at, change)))}
            onMove={(by) => onChange((all) => stepMoved(all, at, at + by))}
            onRemove={() => onChange((all) => all.toSpliced(at, 1))}
          />
        ))}
      </ol>
      <button type="button" class="button small quiet" data-testid="step-add" onClick={add}>
        <PlusIcon /> {steps.length === 0 ? t("What it says there") : t("Next step")}
      </button>
    </div>
  );
}
