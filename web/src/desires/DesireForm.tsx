/** Adds a desire: the form is made from the class's own parameter schema, refusals are shown at their field. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { fromRobot, t } from "../i18n";
import { Problem } from "../protocol/problem";
import { idempotencyKey } from "../protocol/requests";
import type { DesireClass } from "../protocol/types";
import { useApp } from "../state/context";
import { nameAndTitle, spaced } from "../ui/format";
import { LockIcon } from "../ui/icons";
import { FieldInput, Labelled } from "./FieldInput";
import { curl } from "./quick";
import { type Errors, fieldsOf, initialValues, paramsOf, placeErrors, type Values } from "./schema";

const OWN = { intensity: "4", utility: "4", ttl: "" };

export function DesireForm({ classes, onClose }: { classes: DesireClass[]; onClose: () => void }) {
  const { session, store } = useApp();
  const chosen = useSignal(classes[0]?.name ?? "");
  const own = useSignal<Values>(OWN);
  const security = useSignal(false);
  const typed = useSignal<Values>({});
  const errors = useSignal<Errors>({});
  const problem = useSignal<{ title: string; lines: string[] } | null>(null);
  const busy = useSignal(false);
  /** The command, where it cannot be copied. */
  const copied = useSignal("");
  const key = useRef({ body: "", key: "" });
  const form = useRef<HTMLFormElement>(null);
  const kind = classes.find((candidate) => candidate.name === chosen.value);
  const fields = kind ? fieldsOf(kind.schema) : [];
  const scale = store.hello.value?.scale ?? { intensity: 8, utility: 8 };

  useEffect(() => {
    typed.value = initialValues(fields);
    errors.value = {};
    problem.value = null;
  }, [chosen.value]);

  const fail = (found: Errors) => {
    errors.value = found;
    requestAnimationFrame(() => form.current?.querySelector<HTMLElement>("[aria-invalid=true]")?.focus());
  };

  useEffect(() => form.current?.querySelector<HTMLElement>("select")?.focus(), []);

  /** The desire as typed; null: something is wrong, and said so. */
  const read = () => {
    problem.value = null;
    const { params, errors: wrong } = paramsOf(fields, typed.value);
    const found: Errors = Object.fromEntries(
      Object.entries(wrong).map(([name, message]) => [`params.${name}`, message]),
    );
    const number = (name: keyof typeof OWN, limit: number, needed: boolean) => {
      const text = (own.value[name] ?? "").replace(",", ".").trim();
      if (text === "" && !needed) return null;
      const value = Number(text);
      if (text === "" || !Number.isFinite(value) || value < 0 || value > limit || (value === 0 && name !== "utility"))
        found[name] =
          limit === Infinity
            ? t("Seconds, more than 0.")
            : name === "utility"
              ? t("A number from 0 to {limit}.", { limit })
              : t("A number over 0 to {limit}.", { limit });
      return value;
    };
    const intensity = number("intensity", scale.intensity, true);
    const utility = number("utility", scale.utility, true);
    const ttl = number("ttl", Infinity, false);
    if (Object.keys(found).length > 0) {
      fail(found);
      return null;
    }
    errors.value = {};
    const common = { class: chosen.value, intensity, utility, security: security.value, params };
    return ttl === null ? common : { ...common, ttl };
  };

  const copy = async () => {
    const desire = read();
    if (!desire) return;
    const command = curl(location.href, desire, !["localhost", "127.0.0.1", "[::1]"].includes(location.hostname));
    try {
      await navigator.clipboard.writeText(command);
      copied.value = "";
      store.notify("info", t("The command is copied."));
    } catch {
      copied.value = command; // without a secure context there is no clipboard
    }
  };

  const submit = async (event: Event) => {
    event.preventDefault();
    const desire = read();
    if (!desire) return;
    // The same desire sent again after a lost answer keeps its key, so that it is not added twice.
    const body = JSON.stringify(desire);
    if (key.current.body !== body) key.current = { body, key: idempotencyKey() };
    busy.value = true;
    try {
      await session.rest.addDesire(desire, key.current.key);
      key.current = { body: "", key: "" };
      store.notify("info", t("Added a desire: {class}.", { class: spaced(desire.class) }));
      onClose();
    } catch (error) {
      const refused =
        error instanceof Problem ? error : new Problem(0, t("The desire could not be added"), String(error));
      const { byField, rest } = placeErrors(refused.errors, fields);
      problem.value = {
        title: fromRobot(refused.title),
        lines: [refused.detail, ...rest].filter(Boolean).map(fromRobot),
      };
      fail(byField);
    } finally {
      busy.value = false;
    }
  };

  return (
    <form class="desire-form" ref={form} noValidate onSubmit={(event) => void submit(event)} data-testid="desire-form">
      <h2>{t("Add a desire")}</h2>
      <Labelled name="class" title={t("What")} hint={fromRobot(kind?.description ?? "")} error={errors.value["class"]}>
        {(props) => (
          <select
            {...props}
            data-testid="field-class"
            value={chosen.value}
            onChange={(event) => (chosen.value = event.currentTarget.value)}
          >
            {classes.map((candidate) => (
              <option key={candidate.name} value={candidate.name}>
                {nameAndTitle(candidate)}
              </option>
            ))}
          </select>
        )}
      </Labelled>
      {fields.map((field) => (
        <FieldInput
          key={`${chosen.value}.${field.name}`}
          field={field}
          value={typed.value[field.name] ?? field.initial}
          error={errors.value[`params.${field.name}`]}
          onInput={(text) => (typed.value = { ...typed.value, [field.name]: text })}
        />
      ))}
      <div class="form-row">
        {(
          [
            ["intensity", t("Intensity"), t("over 0, to {intensity}", { intensity: scale.intensity })],
            ["utility", t("Utility"), t("0 to {utility}; 0 inhibits", { utility: scale.utility })],
            ["ttl", t("Lasts"), t("seconds; empty: no limit")],
          ] as const
        ).map(([name, title, hint]) => (
          <Labelled key={name} name={name} title={title} hint={hint} error={errors.value[name]}>
            {(props) => (
              <input
                {...props}
                data-testid={`field-${name}`}
                inputMode="decimal"
                autocomplete="off"
                value={own.value[name]}
                onInput={(event) => (own.value = { ...own.value, [name]: event.currentTarget.value })}
              />
            )}
          </Labelled>
        ))}
      </div>
      <label class="check">
        <input
          type="checkbox"
          data-testid="field-security"
          checked={security.value}
          onChange={(event) => (security.value = event.currentTarget.checked)}
        />
        <LockIcon />
        <span>{t("Security: fulfill it even if other desires lose")}</span>
      </label>
      {problem.value && (
        <div class="inline-note error stacked" role="alert" data-testid="form-problem">
          <b>{problem.value.title}</b>
          {problem.value.lines.map((line) => (
            <span key={line}>{line}</span>
          ))}
        </div>
      )}
      <div class="form-actions">
        <button type="submit" class="button accent" data-testid="desire-submit" disabled={busy.value}>
          {busy.value ? t("Adding…") : t("Add the desire")}
        </button>
        <button type="button" class="button quiet" onClick={onClose}>
          {t("Cancel")}
        </button>
        <button
          type="button"
          class="button quiet"
          data-testid="desire-curl"
          title={t("The same from a shell")}
          onClick={() => void copy()}
        >
          {t("Copy as curl")}
        </button>
      </div>
      {copied.value && <textarea class="curl" readOnly rows={4} aria-label={t("Command")} value={copied.value} />}
    </form>
  );
}
