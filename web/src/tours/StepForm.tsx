/** One step: what the robot says, shows and does at once; only what it names has fields. */

import { fieldsOf, initialValues, paramsOf } from "../desires/schema";
import type { Media, Step, TourProblemReport, Wait } from "../protocol/types";
import { useApp } from "../state/context";
import { spaced } from "../ui/format";
import { ChevronIcon, ChevronUpIcon, CloseIcon, PlayIcon, TargetIcon, TrashIcon } from "../ui/icons";
import { Choice, NumberField, Problems, TextFields, TypedField, WordFields } from "./parts";
import { NO_STEP, PARTS, type Part } from "./tourEdits";
import type { PointTarget } from "./tourPath";

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

const NAMES: Record<Part, string> = {
  say: "Say",
  look: "Look",
  point: "Point",
  show: "Show",
  gesture: "Gesture",
  expression: "Face",
  wait: "Wait",
};
const EXPRESSIONS = ["happy", "attractive", "sad", "angry", "calm"] as const;
const WAIT: Wait = { at_most_s: 20, words: {}, claps: null, press: null, all_left: false };
const HEIGHT_M = 1.2;

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
          title="The robot does it now, where it is"
          disabled={!tourTrial.can(step, poster)}
          onClick={() => void tourTrial.step(step, languages, poster)}
        >
          <PlayIcon /> Try
        </button>
        <span class="tour-step-actions">
          {onMove && (
            <>
              <button type="button" class="icon-button" aria-label="Earlier" onClick={() => onMove(-1)}>
                <ChevronUpIcon />
              </button>
              <button type="button" class="icon-button" aria-label="Later" onClick={() => onMove(1)}>
                <ChevronIcon />
              </button>
            </>
          )}
          {onRemove && (
            <button type="button" class="icon-button" aria-label="Remove the step" onClick={onRemove}>
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
              aria-label={`Remove: ${NAMES[part]}`}
              title={`Remove: ${NAMES[part]}`}
              disabled={parts.length === 1}
              onClick={() => drop(part)}
            >
              <CloseIcon />
            </button>
          )}
        </div>
      ))}
      {others.length > 0 && (
        <div class="tour-adds" role="group" aria-label="At the same time">
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
              + {NAMES[part]}
            </button>
          ))}
        </div>
      )}
      <Problems problems={problems} />
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

function PartFields(props: Pick<Props, "step" | "path" | "languages" | "onChange"> & { part: Part }) {
  const { part, step, path, languages, onChange } = props;
  switch (part) {
    case "say":
      return (
        <TextFields
          label="Say"
          long
          texts={step.say}
          languages={languages}
          testid="step-say"
          onDone={(say) => onChange({ say: Object.keys(say).length > 0 ? say : null })}
        />
      );
    case "look":
      return <LookFields look={step.look!} path={path} onChange={onChange} />;
    case "point":
      return (
        <PointFields
          label="Point at"
          point={step.point!}
          target={{ path, part: "point" }}
          onDone={(point) => onChange({ point })}
        />
      );
    case "show":
      return <ShowFields show={step.show!} languages={languages} onDone={(show) => onChange({ show })} />;
    case "gesture":
      return <GestureFields gesture={step.gesture!} onDone={(gesture) => onChange({ gesture })} />;
    case "expression":
      return (
        <Choice
          label="Face"
          value={step.expression!}
          options={[...new Set([...EXPRESSIONS, step.expression!])].map((one) => [one, one] as const)}
          onChange={(expression) => onChange({ expression })}
        />
      );
    case "wait":
      return <WaitFields wait={step.wait!} languages={languages} onDone={(wait) => onChange({ wait })} />;
  }
}

type Point = [number, number, number];

function LookFields({
  look,
  path,
  onChange,
}: {
  look: NonNullable<Step["look"]>;
  path: string;
  onChange: Props["onChange"];
}) {
  const { map } = useApp();
  const point = Array.isArray(look) ? look : null;
  return (
    <>
      <Choice
        label="Look at"
        value={point ? "point" : (look as "visitors" | "poster")}
        options={[
          ["visitors", "the visitors"],
          ["poster", "the poster"],
          ["point", "a point"],
        ]}
        onChange={(to) => {
          const robot = map.robot.peek();
          onChange({ look: to === "point" ? [robot?.x ?? 0, robot?.y ?? 0, HEIGHT_M] : to });
        }}
      />
      {point && (
        <PointFields
          label="Point"
          point={point}
          target={{ path, part: "look" }}
          onDone={(to) => onChange({ look: to })}
        />
      )}
    </>
  );
}

function PointFields(props: { label: string; point: Point; target: PointTarget; onDone: (point: Point) => void }) {
  const { tourPointing } = useApp();
  const { point, target } = props;
  const chosen = tourPointing.isFor(target);
  const set = (at: number) => (value: number | null) => {
    if (value !== null) props.onDone(point.with(at, value) as Point);
  };
  return (
    <div class="tour-point">
      {(["x", "y", "z"] as const).map((axis, at) => (
        <NumberField
          key={axis}
          label={at === 0 ? `${props.label}: x` : axis === "z" ? "height" : axis}
          value={point[at]!}
          testid={`step-${target.part}-${axis}`}
          onDone={set(at)}
        />
      ))}
      <button
        type="button"
        class={`button small ${chosen ? "on" : ""}`}
        data-testid={`step-${target.part}-pick`}
        aria-pressed={chosen}
        title="Click where it is: on the map, or in the camera's picture"
        onClick={() => tourPointing.choose(chosen ? null : target)}
      >
        <TargetIcon /> {chosen ? "Click on the map…" : "On the map"}
      </button>
    </div>
  );
}

function ShowFields({
  show,
  languages,
  onDone,
}: {
  show: Media;
  languages: readonly string[];
  onDone: (show: Media) => void;
}) {
  return (
    <>
      <TypedField
        label="Picture or video"
        value={show.file}
        hint="A file in the folder of tours, as media/arm.jpg."
        onDone={(file) => onDone({ ...show, file: file.trim() })}
      />
      <TextFields
        label="What it shows"
        texts={show.alt}
        languages={languages}
        onDone={(alt) => onDone({ ...show, alt })}
      />
    </>
  );
}

/** A class of desires of this program that ends by itself, with its parameters. */
function GestureFields({
  gesture,
  onDone,
}: {
  gesture: NonNullable<Step["gesture"]>;
  onDone: (gesture: NonNullable<Step["gesture"]>) => void;
}) {
  const { store } = useApp();
  const classes = (store.hello.value?.classes ?? []).filter(({ name, served }) => served && !OTHERS.has(name));
  const names = [...new Set([gesture.class, ...classes.map(({ name }) => name)])];
  const kind = classes.find(({ name }) => name === gesture.class);
  const fields = kind ? fieldsOf(kind.schema) : [];
  const values = initialValues(fields);
  return (
    <>
      <Choice
        label="Gesture"
        value={gesture.class}
        options={names.map((name) => [name, spaced(name)] as const)}
        onChange={(name) => onDone({ class: name, params: {} })}
      />
      {fields.map((field) => (
        <TypedField
          key={`${gesture.class}.${field.name}`}
          label={field.title}
          value={String(gesture.params[field.name] ?? "")}
          placeholder={values[field.name] ?? ""}
          onDone={(typed) => {
            const { [field.name]: _, ...rest } = gesture.params;
            if (typed.trim() === "") return onDone({ ...gesture, params: rest });
            // What is no such value is handed on as it was typed: the robot says what is wrong with it.
            const read = paramsOf([field], { [field.name]: typed }).params[field.name] as string | number | boolean;
            onDone({ ...gesture, params: { ...rest, [field.name]: read ?? typed } });
          }}
        />
      ))}
    </>
  );
}

/** What has a form of its own here, or is the guide's. */
const OTHERS: ReadonlySet<string> = new Set(["Say", "Ask", "LookAt", "PointAt", "Express", "GoTo", "SLAM", "Record"]);

function WaitFields({
  wait,
  languages,
  onDone,
}: {
  wait: Wait;
  languages: readonly string[];
  onDone: (wait: Wait) => void;
}) {
  return (
    <>
      <NumberField
        label="Wait at most (s)"
        value={wait.at_most_s}
        testid="step-wait"
        onDone={(at_most_s) => at_most_s !== null && onDone({ ...wait, at_most_s })}
      />
      <WordFields
        label="Until one of these words"
        words={wait.words}
        languages={languages}
        onDone={(words) => onDone({ ...wait, words })}
      />
      <TextFields
        label="Until a press on the button"
        texts={wait.press}
        languages={languages}
        onDone={(press) => onDone({ ...wait, press: Object.keys(press).length > 0 ? press : null })}
      />
      <NumberField label="Until so many claps" value={wait.claps} onDone={(claps) => onDone({ ...wait, claps })} />
      <label class="check">
        <input
          type="checkbox"
          checked={wait.all_left}
          onChange={(event) => onDone({ ...wait, all_left: event.currentTarget.checked })}
        />
        <span>Until all visitors have left</span>
      </label>
    </>
  );
}
