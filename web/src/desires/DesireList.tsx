/** The desires there are: changed in place, removed, with who asked, how long they last and what became of them. */

import { useSignal } from "@preact/signals";
import { fromRobot, named, t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { Accomplishment, Desire, DesireProgress, DesireReport, Source } from "../protocol/types";
import { useApp } from "../state/context";
import { ago, clockSpan, clockTime, number, left as remaining, spaced } from "../ui/format";
import { LockIcon, TrashIcon } from "../ui/icons";
import { Stepper } from "../ui/Stepper";

interface Props {
  desires: readonly Desire[] | null;
  /** The last reports on some of them. */
  accomplishments: readonly Accomplishment[];
  /** Which are intended and exploited; nothing of them where the robot does not say. */
  progress: readonly DesireProgress[];
}

export function DesireList({ desires, accomplishments, progress }: Props) {
  if (desires === null) return <p class="empty">{t("Waiting for the robot's desires…")}</p>;
  if (desires.length === 0)
    return <p class="empty">{t("No desires. Add one to give the robot something to attend to.")}</p>;
  return (
    <ul class="desires">
      {desires.map((desire) => (
        <Row
          key={desire.id}
          desire={desire}
          report={accomplishments.find((report) => report.desire_id === desire.id) ?? null}
          progress={progress.find(({ id }) => id === desire.id) ?? null}
        />
      ))}
    </ul>
  );
}

/** The desires that left last, the newest first. */
export function EndedList({ ended }: { ended: readonly DesireReport[] }) {
  const now = useApp().store.seconds.value;
  if (ended.length === 0) return null;
  return (
    <ul class="ended-desires" aria-label={t("Ended")} data-testid="ended-desires">
      {ended.map((report) => (
        <li key={`${report.id}@${report.ended}`} data-id={report.id} data-outcome={report.outcome}>
          <b>{spaced(report.class)}</b>
          <OutcomeTag outcome={report.outcome ?? "withdrawn"} />
          <time title={clockTime(report.ended!)}>
            {now === null ? clockTime(report.ended!) : ago(now - report.ended!)}
          </time>
          <p class="desire-by">{[sourceWords(report.source), fromRobot(report.reason)].filter(Boolean).join(" · ")}</p>
        </li>
      ))}
    </ul>
  );
}

function OutcomeTag({ outcome }: { outcome: string }) {
  return <span class={`tag ${outcome}`}>{named(outcome)}</span>;
}

interface RowProps {
  desire: Desire;
  report: Accomplishment | null;
  progress: DesireProgress | null;
}

function Row({ desire, report, progress }: RowProps) {
  const { store, session } = useApp();
  const problem = useSignal("");
  const scale = store.hello.value?.scale ?? { intensity: 8, utility: 8 };
  const attempt = async (work: Promise<void>): Promise<boolean> => {
    problem.value = "";
    try {
      await work;
      return true;
    } catch (error) {
      problem.value = inWords(error);
      return false;
    }
  };
  const change = (what: Partial<Pick<Desire, "intensity" | "utility">>) =>
    attempt(session.rest.changeDesire(desire.id, what));
  const name = spaced(desire.class);
  const shown = store.of("emotions").value?.shown ?? null;
  const params = Object.entries(desire.params).filter(([, value]) => value !== "" && value !== null);
  return (
    <li
      class="desire"
      data-testid="desire-row"
      data-id={desire.id}
      data-class={desire.class}
      data-intensity={desire.intensity}
      data-utility={desire.utility}
    >
      <div class="desire-head">
        <b>{name}</b>
        {desire.security && (
          <span class="tag security" title={t("Security: must be fulfilled")}>
            <LockIcon />
            {t("security")}
          </span>
        )}
        {report && <OutcomeTag outcome={report.outcome} />}
        {progress && <ProgressTag progress={progress} />}
        <TimeLeft expires={desire.expires} />
        <button
          type="button"
          class="icon-button"
          data-testid="desire-remove"
          aria-label={t("Remove the desire {name} of {source}", { name, source: desire.source.name })}
          onClick={() => void attempt(session.rest.removeDesire(desire.id))}
        >
          <TrashIcon />
        </button>
      </div>
      <p class="desire-by">
        {[
          sourceWords(desire.source),
          shown?.desire === desire.id && t("shows {emotion}", { emotion: named(shown.emotion) }),
          report && fromRobot(report.reason),
          desire.modulation && `+${number(desire.modulation.by, 2)} (${named(desire.modulation.emotion)})`,
        ]
          .filter(Boolean)
          .join(" · ")}
      </p>
      {params.length > 0 && (
        <p class="desire-params">
          {params
            .map(([key, value]) => `${key} ${typeof value === "number" ? number(value, 2) : JSON.stringify(value)}`)
            .join(" · ")}
        </p>
      )}
      <div class="desire-values">
        <Stepper
          label={t("Intensity")}
          tone="intensity"
          value={desire.intensity}
          limit={scale.intensity}
          onChange={(intensity) => change({ intensity })}
        />
        <Stepper
          label={t("Utility")}
          tone="utility"
          value={desire.utility}
          limit={scale.utility}
          zero={t("inhibits")}
          onChange={(utility) => change({ utility })}
        />
      </div>
      {problem.value && (
        <p class="inline-note error" role="alert">
          {problem.value}
        </p>
      )}
    </li>
  );
}

/** Exploited, or for how long it has been intended in vain; a moment says nothing. */
function ProgressTag({ progress }: { progress: DesireProgress }) {
  const now = useApp().store.seconds.value;
  const { intended, exploited, intended_since: since, exploited_since: left } = progress;
  if (exploited)
    return (
      <span class="tag exploited" data-testid="desire-exploited" title={t("What was selected for it is at work.")}>
        {t("exploited")}
      </span>
    );
  const idle = now === null || since === null ? 0 : now - Math.max(since, left ?? since);
  if (!intended || idle < 3) return null;
  return (
    <span class="tag idle" data-testid="desire-idle" title={t("Selected, but what was selected for it does not work.")}>
      {t("not exploited for {time}", { time: clockSpan(idle) })}
    </span>
  );
}

function TimeLeft({ expires }: { expires: number | null }) {
  const { store } = useApp();
  const now = store.now.value;
  if (expires === null || now === null) return null;
  return <span class="desire-left">{remaining(expires - now)}</span>;
}

/** The motivation that desires it, and of what kind that is. */
export function motiveWords(motive: Source["motive"], name: string): string {
  if (motive === "instinctive") return t("by {name}, for what the robot itself needs", { name });
  if (motive === "rational") return t("by {name}, for its task", { name });
  if (motive === "emotional") return t("by {name}, because of a conflict or a feeling", { name });
  return t("by {name}", { name });
}

function sourceWords(source: Source): string {
  if (source.rule)
    return t("by rule “{rule}”: {event}, {time}", {
      rule: source.rule,
      event: fromRobot(source.event),
      time: source.applied === null ? "" : clockTime(source.applied),
    });
  if (source.kind === "motivation") return motiveWords(source.motive, spaced(source.name));
  if (source.kind === "rest") return t("by {name} over REST", { name: source.name });
  return t("by {name}", { name: source.name });
}
