/** The rules by which something is desired without code: when each applied last, and what it desires now. */

import { fromRobot, langOf, t } from "../i18n";
import { panel } from "../panels/panel";
import type { RuleReport } from "../protocol/types";
import { useApp } from "../state/context";
import type { Message } from "../state/latest";
import { ago, clockTime } from "../ui/format";
import { WarnIcon } from "../ui/icons";

export const rulesPanel = panel({ type: "rules", tab: "Attention", Card: Rules });

function Rules({ message }: { message: Message<"rules"> | null }) {
  if (message === null) return null;
  return (
    <section class="card" aria-label={t("Rules")} data-testid="rules">
      <h2>
        {t("Rules")} <span class="count">{message.rules.length}</span>
      </h2>
      {message.problem && (
        <p class="inline-note error" role="alert" data-testid="rules-problem">
          <WarnIcon />
          <span>
            <b>{t("The files were changed and have a mistake; the rules are those before.")}</b> {message.problem}
          </span>
        </p>
      )}
      {message.rules.length === 0 && <p class="empty">{t("There are none.")}</p>}
      <ul class="rules">
        {message.rules.map((rule) => (
          <Row key={rule.name} rule={rule} />
        ))}
      </ul>
    </section>
  );
}

function Row({ rule }: { rule: RuleReport }) {
  const now = useApp().store.seconds.value;
  const { name, about, words, file, line, enabled, fired, last_fired: last, problem } = rule;
  const active = rule.desires.length > 0;
  return (
    <li data-testid="rule" data-name={name} data-fired={fired} data-active={active}>
      <p class="rule-head">
        <b title={about}>{name}</b>
        {active && <span class="tag fulfilled">{t("desires")}</span>}
        {!enabled && <span class="tag">{t("switched off")}</span>}
        <time title={last === null ? undefined : `${clockTime(last)} · ${fromRobot(rule.last_event)}`}>
          {last === null ? t("never") : now === null ? clockTime(last) : ago(now - last)}
        </time>
      </p>
      <p class="desire-by">
        <span lang={langOf(words)}>{fromRobot(words)}</span> · {file}:{line}
        {fired > 1 && ` · ${t("{count}×", { count: fired })}`}
      </p>
      {problem && (
        <p class="inline-note warn" role="alert">
          {problem}
        </p>
      )}
    </li>
  );
}
