/** Why the robot drives slower than commanded, in words; and the button that overrides the collision monitor while held. */

import { fromRobot, langOf, t } from "../i18n";
import { useApp } from "../state/context";
import { overrides } from "./machine";

export function Limited() {
  const { ahead, drive, store } = useApp();
  const status = store.live.value ? store.of("status").value : null;
  const said = status?.limited ?? "";
  const limited = fromRobot(said);
  const { source, screenOverride } = drive.state.value;
  const held = overrides(drive.state.value);
  const mine = store.of("status").value?.driver?.mine ?? false;
  // The hold stays under the finger that holds it, whatever the robot says meanwhile.
  const offered = drive.refusal.value === null && (held || (limited !== "" && (mine || source !== null)));
  const hold = (on: boolean) => drive.input({ type: "override", held: on });
  const late = mine || source !== null ? status?.slowed || ahead.wrong.value : "";
  if (!limited && !offered && late) {
    return (
      <div class="drive-limited" data-testid="slowed">
        <p role="status" lang={langOf(late)}>
          {fromRobot(late)}
        </p>
      </div>
    );
  }
  if (!limited && !offered) return null;
  return (
    <div class="drive-limited" data-testid="limited" data-override={held}>
      <p role="status" lang={langOf(said)}>
        {limited
          ? `${limited[0]!.toUpperCase()}${limited.slice(1)}.`
          : t("The collision monitor is off while you hold this.")}
      </p>
      {offered && (
        <button
          type="button"
          class={`button quiet hold ${held ? "held" : ""}`}
          data-testid="override"
          aria-pressed={screenOverride}
          title={t("Hold this, O or a gamepad trigger while driving: the robot crawls and does not stop for obstacles")}
          onPointerDown={(event) => {
            if (event.button !== 0) return;
            event.preventDefault(); // the keys go on driving
            event.currentTarget.setPointerCapture(event.pointerId);
            hold(true);
          }}
          onPointerUp={() => hold(false)}
          onPointerCancel={() => hold(false)}
          onLostPointerCapture={() => hold(false)}
          onContextMenu={(event) => event.preventDefault()}
        >
          {t("Hold to crawl")} <kbd class="only-wide">O</kbd>
        </button>
      )}
    </div>
  );
}
