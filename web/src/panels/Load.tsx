/** CPU by module against the budget, and how each module is. */

import { fromRobot, langOf, named, plural, t } from "../i18n";
import type { Load as LoadMessage, ModuleLoad } from "../protocol/types";
import { useApp } from "../state/context";
import { attendedCpu } from "../state/load";
import { divisor, millis, number, spaced } from "../ui/format";
import { ChevronIcon, WarnIcon } from "../ui/icons";
import { Meter } from "../ui/Meter";
import { ClosedLoop } from "./ClosedLoop";
import { CpuPlot } from "./CpuPlot";

export function Load({ message: load }: { message: LoadMessage | null }) {
  return (
    <section class="card" aria-label={t("Load")} data-testid="load">
      <h2>{t("Load")}</h2>
      {load ? <Body load={load} /> : <p class="empty">{t("Waiting for the next figures (once a second)…")}</p>}
    </section>
  );
}

function Body({ load }: { load: LoadMessage }) {
  const modules = [...load.modules].sort((a, b) => rank(a) - rank(b) || b.cpu - a.cpu || a.name.localeCompare(b.name));
  const { store } = useApp();
  const attended = attendedCpu(load, store.of("intention").value);
  const budget = load.budget;
  const most = Math.max(2, ...modules.map((module) => Math.max(module.cpu, module.cpu_budget ?? 0)));
  return (
    <>
      {budget !== null && (
        <Meter
          label={t("Governed by attention")}
          value={attended}
          limit={budget}
          full={Math.max(budget, attended) * 1.1}
          text={t("{attended} % of a core · budget {budget} %", {
            attended: number(attended, 1),
            budget: number(budget, 1),
          })}
        />
      )}
      <Meter
        label={t("Whole process")}
        value={load.process_cpu}
        limit={Math.max(100, load.process_cpu)}
        text={t("{share} % of a core", { share: number(load.process_cpu, 0) })}
      />
      {load.loop && <ClosedLoop loop={load.loop} />}
      <CpuPlot />
      <ul class="modules">
        {modules.map((module) => (
          <Row key={module.name} module={module} full={most} />
        ))}
      </ul>
    </>
  );
}

/** What is wrong comes first. */
function rank(module: ModuleLoad): number {
  return { failed: 0, hung: 0, starting: 1, running: 1, stopped: 2 }[module.state];
}

function Row({ module, full }: { module: ModuleLoad; full: number }) {
  return (
    <li
      class={`module ${module.state}`}
      data-testid={`module-${module.name}`}
      data-state={module.state}
      data-cpu={module.cpu}
    >
      <details>
        <summary>
          <span class="module-name">{named(module.title) || spaced(module.name)}</span>
          {module.state !== "running" && <span class={`tag ${module.state}`}>{named(module.state)}</span>}
          <span class="module-cpu">{number(module.cpu, 1)} %</span>
          <ChevronIcon />
          <span
            class={`module-bar ${module.cpu_budget != null && module.cpu > module.cpu_budget ? "over" : ""}`}
            title={
              module.cpu_budget != null
                ? t("expected under {cpuBudget} %", { cpuBudget: number(module.cpu_budget) })
                : ""
            }
          >
            <span style={{ width: `${Math.min(100, (100 * module.cpu) / full)}%` }} />
            {module.cpu_budget != null && <i style={{ left: `${Math.min(100, (100 * module.cpu_budget) / full)}%` }} />}
          </span>
        </summary>
        <Inputs module={module} />
      </details>
      {module.problem && (
        <p class="inline-note error">
          <WarnIcon />
          <span lang={langOf(module.problem)}>{fromRobot(module.problem)}</span>
        </p>
      )}
    </li>
  );
}

function Inputs({ module }: { module: ModuleLoad }) {
  return (
    <div class="module-detail">
      <p class="muted small">
        {module.name}
        {module.message_cpu_us !== null &&
          ` · ${t("{time} ms of CPU per message", { time: number(module.message_cpu_us / 1000, 2) })}`}
        {module.restarts > 0 && ` · ${plural(module.restarts, "restarted once", "restarted {count} times")}`}
      </p>
      {module.inputs.length === 0 ? (
        <p class="muted small">{t("No inputs: a source.")}</p>
      ) : (
        <table>
          <thead>
            <tr>
              <th scope="col">{t("Input")}</th>
              <th scope="col">φ</th>
              <th scope="col">{t("Passed")}</th>
              <th scope="col">{t("Decimated")}</th>
              <th scope="col">{t("Dropped")}</th>
              <th scope="col">{t("Age ms")}</th>
            </tr>
          </thead>
          <tbody>
            {module.inputs.map((input) => (
              <tr key={input.name}>
                <th scope="row" title={input.channel}>
                  {input.name}
                </th>
                <td>{divisor(input.divisor)}</td>
                <td>{input.passed}</td>
                <td>{input.decimated}</td>
                <td class={input.dropped > 0 ? "some" : ""}>{input.dropped}</td>
                <td>{millis(input.age_ms)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </div>
  );
}
