/** The robot's name in the bar; where there are others, a list of all: how they are, who drives, and their pages. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { FleetRobot } from "../protocol/types";
import { useApp } from "../state/context";
import { usePopup } from "../ui/usePopup";
import { detailWords, nameOf, robotWords } from "./fleetText";

const ASK_EVERY_MS = 2000;

export function FleetMenu() {
  const { store, session } = useApp();
  const robots = useSignal<readonly FleetRobot[]>([]);
  const problem = useSignal("");
  const { open, button, box } = usePopup("a");
  const live = store.live.value;
  const hello = store.hello.value;
  useEffect(() => {
    if (!live) return;
    let gone = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async () => {
      try {
        const found = await session.rest.fleet();
        if (gone) return;
        robots.value = found.robots;
        problem.value = "";
      } catch (error) {
        if (gone) return;
        problem.value = inWords(error);
      }
      if (open.value) timer = setTimeout(ask, ASK_EVERY_MS);
    };
    void ask();
    return () => {
      gone = true;
      clearTimeout(timer);
    };
  }, [live, open.value]);
  const name = hello ? hello.robot.called : t("No robot yet");
  if (robots.value.length < 2) return <>{name}</>;
  return (
    <span class="fleet-menu">
      <button
        type="button"
        ref={button}
        class="fleet-button"
        data-testid="fleet"
        aria-haspopup="dialog"
        aria-expanded={open.value}
        title={t("All robots: how they are, and who drives them")}
        onClick={() => (open.value = !open.value)}
      >
        {name} <span aria-hidden="true">▾</span>
      </button>
      {open.value && (
        <div ref={box} class="layout-box fleet-box" role="dialog" aria-label={t("Robots")} data-testid="fleet-box">
          <ul>
            {robots.value.map((robot) => (
              <li
                key={robot.url}
                class={`fleet-robot ${robot.state}`}
                data-testid="fleet-robot"
                data-state={robot.state}
              >
                <p class="fleet-name">
                  <b>{nameOf(robot)}</b>
                  {robot.simulated && <i class="tag">{t("simulated")}</i>}
                  {robot.url ? (
                    <a href={robot.url} target="_blank" rel="noopener noreferrer" class="button small">
                      {t("Open")}
                      <span class="visually-hidden"> {nameOf(robot)}</span>
                    </a>
                  ) : (
                    <span class="muted small">{t("this page")}</span>
                  )}
                </p>
                <p class="fleet-state">{robotWords(robot)}</p>
                {detailWords(robot) && <p class="muted small">{detailWords(robot)}</p>}
              </li>
            ))}
          </ul>
          {problem.value && <p class="inline-note error">{problem.value}</p>}
        </div>
      )}
    </span>
  );
}
