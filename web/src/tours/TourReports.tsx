/** Reports on tours that are over: counts of people and nothing else of them; all as a table. */

import { useSignal } from "@preact/signals";
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
    <section class="card" aria-label="Reports on tours" data-testid="tour-reports">
      <h2 class="card-head">
        Reports <span class="count">{reports.length}</span>
        <a class="button small quiet" data-testid="tour-reports-csv" href={session.rest.tourReportsTable()} download>
          As a table (CSV)
        </a>
      </h2>
      <ul class="tours">
        {reports.slice(0, SHOWN).map((report) => (
          <Row key={report.run} report={report} />
        ))}
      </ul>
      {reports.length > SHOWN && <p class="muted small">The table has the {reports.length - SHOWN} older ones, too.</p>}
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
          <dt>Visitors</dt>
          <dd>{`${report.people_begin} at the start, ${report.people_most} at most, ${report.people_end} at the end`}</dd>
          <dt>Driven</dt>
          <dd>{`${number(report.driven_m, 0)} m`}</dd>
          <dt>Waited for visitors</dt>
          <dd>{timesWords(report.waits, report.waited_s)}</dd>
          <dt>Paused</dt>
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
            words="The report is gone then."
            yes="Delete"
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
            <TrashIcon /> Delete
          </button>
        )}
      </details>
    </li>
  );
}

function Stop({ stop }: { stop: RunReport["stops"][number] }) {
  const asked = Object.values(stop.questions).reduce((sum, count) => sum + count, 0);
  const what = stop.presented ? "presented" : stop.skipped ? "skipped" : "left";
  const time = stop.arrived !== null && stop.ended !== null ? `, ${clockSpan(stop.ended - stop.arrived)} min` : "";
  const questions = asked === 0 ? "" : asked === 1 ? ", 1 question" : `, ${asked} questions`;
  return (
    <>
      <dt>{idWords(stop.stop)}</dt>
      <dd>{`${what}${time}, ${stop.people} there${questions}`}</dd>
    </>
  );
}

function FailureRow({ stop, what }: { stop: string; what: string }) {
  return (
    <>
      <dt class="tour-lack">{idWords(stop) || "Failed"}</dt>
      <dd class="tour-lack">{sentence(what)}</dd>
    </>
  );
}
