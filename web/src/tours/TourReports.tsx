/** Reports on tours that are over: counts of people and nothing else of them; all as a table. */

import { useSignal } from "@preact/signals";
import { plural, t } from "../i18n";
import { Confirm } from "../map/Confirm";
import type { RunReport } from "../protocol/types";
import { useApp } from "../state/context";
import { clockSpan, dayTime, number, sentence } from "../ui/format";
import { TrashIcon } from "../ui/icons";
import { textOf } from "./tourEdits";
import { idWords, reportWords, timesWords } from "./tourRunText";

/** As many as one looks at; the table has all. */
const SHOWN = 20;

export function TourReports() {
  const { session, tourRun } = useApp();
  const reports = tourRun.reports.value;
  if (!reports || reports.length === 0) return null;
  return (
    <section class="card" aria-label={t("Reports on tours")} data-testid="tour-reports">
      <h2 class="card-head">
        {t("Reports")} <span class="count">{reports.length}</span>
        <a
          class="button small quiet"
          data-testid="tour-reports-csv"
          href={session.tourRest.tourReportsTable()}
          download
        >
          {t("As a table (CSV)")}
        </a>
      </h2>
      <ul class="tours">
        {reports.slice(0, SHOWN).map((report) => (
          <Row key={report.run} report={report} />
        ))}
      </ul>
      {reports.length > SHOWN && (
        <p class="muted small">
          {plural(
            reports.length - SHOWN,
            "The table has the older one, too.",
            "The table has the {count} older ones, too.",
          )}
        </p>
      )}
    </section>
  );
}

function Row({ report }: { report: RunReport }) {
  const { tourRun } = useApp();
  const asked = useSignal(false);
  const { run, title, language, began, failures } = report;
  return (
    <li class="tour-row" data-testid="tour-report" data-run={run}>
      <details class="tour-report">
        <summary>
          <b>{textOf(title, [language])}</b>
          <span class="muted small">{dayTime(began)}</span>
          <span class="small">{reportWords(report)}</span>
        </summary>
        <dl class="tour-report-figures small">
          <dt>{t("Visitors")}</dt>
          <dd>
            {t("{peopleBegin} at the start, {peopleMost} at most, {peopleEnd} at the end", {
              peopleBegin: report.people_begin,
              peopleMost: report.people_most,
              peopleEnd: report.people_end,
            })}
          </dd>
          <dt>{t("Driven")}</dt>
          <dd>{`${number(report.driven_m, 0)} m`}</dd>
          <dt>{t("Waited for visitors")}</dt>
          <dd>{timesWords(report.waits, report.waited_s)}</dd>
          <dt>{t("Paused")}</dt>
          <dd>{timesWords(report.pauses, report.paused_s)}</dd>
          {report.stops.map((stop, index) => (
            <Stop key={`${index} ${stop.stop}`} stop={stop} />
          ))}
          {failures.map(({ stop, what }, index) => (
            <FailureRow key={`${index} ${what}`} stop={stop} what={what} />
          ))}
        </dl>
        {asked.value ? (
          <Confirm
            words={t("The report is gone then.")}
            yes={t("Delete")}
            onYes={() => void tourRun.deleteReport(run)}
            onNo={() => (asked.value = false)}
          />
        ) : (
          <button
            type="button"
            class="button small quiet"
            data-testid="tour-report-delete"
            onClick={() => (asked.value = true)}
          >
            <TrashIcon /> {t("Delete")}
          </button>
        )}
      </details>
    </li>
  );
}

function Stop({ stop }: { stop: RunReport["stops"][number] }) {
  const asked = Object.values(stop.questions).reduce((sum, count) => sum + count, 0);
  const what = stop.presented ? t("presented") : stop.skipped ? t("skipped") : t("left|a stop");
  const time =
    stop.arrived !== null && stop.ended !== null
      ? t(", {time} min", { time: clockSpan(stop.ended - stop.arrived) })
      : "";
  const questions = asked === 0 ? "" : plural(asked, ", {count} question", ", {count} questions");
  return (
    <>
      <dt>{idWords(stop.stop)}</dt>
      <dd>{t("{what}{time}, {people} there{questions}", { what, time, people: stop.people, questions })}</dd>
    </>
  );
}

function FailureRow({ stop, what }: { stop: string; what: string }) {
  return (
    <>
      <dt class="tour-lack">{idWords(stop) || t("Failed")}</dt>
      <dd class="tour-lack">{sentence(what)}</dd>
    </>
  );
}
