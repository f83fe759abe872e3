/** Small parts of the editor: fields that hand on what was typed once it is finished, texts by language, problems. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import type { TourProblemReport } from "../protocol/types";
import { sentence } from "../ui/format";
import { WarnIcon } from "../ui/icons";
import { type Texts, withText, withWords } from "./tourEdits";

interface FieldProps {
  label: string;
  value: string;
  testid?: string;
  hint?: string;
  placeholder?: string;
  /** Several lines. */
  long?: boolean;
  maxLength?: number;
  disabled?: boolean;
  /** Called when it is left or Enter is pressed, if it was changed. */
  onDone: (value: string) => void;
}

/** An edit is what was typed until the field was left: one request to the robot, one step to undo. */
export function TypedField(props: FieldProps) {
  const id = useId();
  const typed = useSignal<string | null>(null);
  const now = useRef(props);
  now.current = props;
  const done = () => {
    const value = typed.peek();
    typed.value = null;
    if (value !== null && value !== now.current.value) now.current.onDone(value);
  };
  // What was typed is not lost with the form.
  useEffect(() => done, []);
  const shared = {
    id,
    "data-testid": props.testid,
    value: typed.value ?? props.value,
    placeholder: props.placeholder,
    maxLength: props.maxLength,
    disabled: props.disabled,
    autocomplete: "off",
    onInput: (event: { currentTarget: { value: string } }) => (typed.value = event.currentTarget.value),
    onBlur: done,
  };
  return (
    <div class="field">
      <label for={id}>{props.label}</label>
      {props.long ? (
        <textarea {...shared} rows={Math.min(8, 2 + Math.floor(shared.value.length / 60))} />
      ) : (
        <input {...shared} onKeyDown={(event) => event.key === "Enter" && done()} />
      )}
      {props.hint && <span class="field-hint">{props.hint}</span>}
    </div>
  );
}

export function NumberField(
  props: Omit<FieldProps, "value" | "onDone"> & { value: number | null; onDone: (value: number | null) => void },
) {
  const { value, onDone, ...rest } = props;
  return (
    <TypedField
      {...rest}
      value={value === null ? "" : String(value)}
      onDone={(text) => {
        const plain = text.replace(",", ".").replace("−", "-").trim();
        const number = Number(plain);
        // What is no number stays what it was.
        if (plain === "") onDone(null);
        else if (Number.isFinite(number)) onDone(number);
      }}
    />
  );
}

export function Choice<T extends string>(props: {
  label: string;
  value: T;
  options: readonly (readonly [value: T, words: string])[];
  testid?: string;
  onChange: (value: T) => void;
}) {
  const id = useId();
  return (
    <div class="field">
      <label for={id}>{props.label}</label>
      <select
        id={id}
        data-testid={props.testid}
        value={props.value}
        onChange={(event) => props.onChange(event.currentTarget.value as T)}
      >
        {props.options.map(([value, words]) => (
          <option key={value} value={value}>
            {words}
          </option>
        ))}
      </select>
    </div>
  );
}

/** One field for each language of the tour. */
export function TextFields(props: {
  label: string;
  texts: Texts | null;
  languages: readonly string[];
  testid?: string;
  long?: boolean;
  onDone: (texts: Texts) => void;
}) {
  const { texts, languages } = props;
  return (
    <>
      {languages.map((language) => (
        <TypedField
          key={language}
          label={languages.length > 1 ? `${props.label}, ${languageName(language)}` : props.label}
          value={texts?.[language] ?? ""}
          testid={props.testid && `${props.testid}-${language}`}
          {...(props.long ? { long: true, maxLength: 2000 } : { maxLength: 100 })}
          onDone={(text) => props.onDone(withText(texts, language, text))}
        />
      ))}
    </>
  );
}

/** Words to listen for, by language. */
export function WordFields(props: {
  label: string;
  words: Record<string, string[]>;
  languages: readonly string[];
  onDone: (words: Record<string, string[]>) => void;
}) {
  return (
    <>
      {props.languages.map((language) => (
        <TypedField
          key={language}
          label={props.languages.length > 1 ? `${props.label}, ${languageName(language)}` : props.label}
          value={(props.words[language] ?? []).join(", ")}
          placeholder="next, go on"
          onDone={(typed) => props.onDone(withWords(props.words, language, typed))}
        />
      ))}
    </>
  );
}

/** What is wrong here; nothing where nothing is. */
export function Problems({ problems }: { problems: readonly TourProblemReport[] }) {
  if (problems.length === 0) return null;
  return (
    <ul class="tour-problems">
      {problems.map(({ field, message, severity }) => (
        <li key={`${field} ${message}`} class={severity} data-testid="tour-problem" data-field={field}>
          <WarnIcon />
          <span>
            {severity === "mistake" && <b>Not kept: </b>}
            {sentence(message)}
          </span>
        </li>
      ))}
    </ul>
  );
}

/** What is not needed every day, folded. */
export function More({ title, children, testid }: { title: string; children: ComponentChildren; testid?: string }) {
  return (
    <details class="tour-more" data-testid={testid}>
      <summary>{title}</summary>
      <div class="tour-form">{children}</div>
    </details>
  );
}

/** "English"; of a tag that the browser does not know, the tag. */
export function languageName(tag: string): string {
  try {
    return new Intl.DisplayNames(["en"], { type: "language" }).of(tag) ?? tag;
  } catch {
    return tag;
  }
}
