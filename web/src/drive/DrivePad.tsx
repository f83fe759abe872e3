/** The operator's controls on screen: stick, speed, who drives, and what the wheels are given. */

import { fromRobot, rich, t } from "../i18n";
import { goalOf } from "../map/mapText";
import type { Velocity } from "../protocol/generated";
import { useApp } from "../state/context";
import { number } from "../ui/format";
import { KeyboardIcon } from "../ui/icons";
import { DriveSettings } from "./DriveSettings";
import { PRESETS } from "./driveController";
import { heldWords } from "./driveText";
import { Head, HeadHint } from "./Head";
import { Limited } from "./Limited";
import { Stick } from "./Stick";
import { WheelOfAnother } from "./Wheel";

export function DrivePad() {
  const { drive, session, store } = useApp();
  const { factor, source, command } = drive.state.value;
  const status = store.of("status").value;
  const applied = status?.guard.applied;
  const words = applied ? speedWords(applied) : t("no figures");
  const driver = status?.driver ?? null;
  const live = store.live.value;
  const { strafes } = store.body.value;

  return (
    <section class="drive-pad" data-testid="drive-pad" data-source={source ?? ""} aria-label={t("Drive")}>
      <Stick drive={drive} words={words} />
      <div class="drive-side">
        <p class="drive-speed" role="group" aria-label={t("Wheels: {words}", { words })}>
          <span>
            <b>{number(live ? applied?.linear_mps : null, 2)}</b> m/s
          </span>
          {strafes && (
            <span>{rich("{speed} m/s left", { speed: <b>{number(live ? applied?.lateral_mps : null, 2)}</b> })}</span>
          )}
          <span>
            <b>{number(live && applied ? (applied.angular_radps * 180) / Math.PI : null, 0)}</b> °/s
          </span>
        </p>
        <div class="drive-speeds">
          <div class="segmented" role="radiogroup" aria-label={t("Speed")}>
            {PRESETS.map((preset) => (
              <button
                key={t(preset.name)}
                type="button"
                role="radio"
                aria-checked={factor === preset.factor}
                data-testid={`speed-${preset.name.toLowerCase()}`}
                onClick={() => drive.preset(preset.factor)}
              >
                {t(preset.name)}
              </button>
            ))}
          </div>
          <DriveSettings />
        </div>
        {strafes && (
          <button
            type="button"
            class="button quiet"
            aria-pressed={drive.stickStrafes.value}
            data-testid="stick-strafes"
            onClick={() => {
              drive.stickStrafes.value = !drive.stickStrafes.value;
            }}
          >
            {drive.stickStrafes.value ? t("Stick aside: moves sideways") : t("Stick aside: turns")}
          </button>
        )}
        {driver && !driver.mine && live ? (
          <WheelOfAnother name={driver.operator} />
        ) : driver?.mine &&
          !source &&
          !command.head_held &&
          drive.refusal.value === null &&
          drive.keyboard.value === "page" ? (
          <button
            type="button"
            class="button quiet"
            data-testid="release-control"
            onClick={() => session.send({ type: "release_control" })}
          >
            {t("Release control")}
          </button>
        ) : (
          <Hint />
        )}
        <HeadHint />
        <Limited />
      </div>
      <Head />
    </section>
  );
}

function Hint() {
  const { drive, store } = useApp();
  const guard = store.of("status").value?.guard;
  const refusal = drive.refusal.value ?? (guard?.state === "sensor_failure" ? fromRobot(guard.reason) : null);
  const { source, keys } = drive.state.value;
  if (refusal) return <p class="drive-hint warn">{refusal}</p>;
  if (source) {
    const slow = keys.has("ShiftLeft") || keys.has("ShiftRight");
    return (
      <p class="drive-hint active" data-testid="drive-hint">
        {heldWords(source, slow, goalOf(store.of("desires").value?.desires) !== null)}
      </p>
    );
  }
  if (drive.keyboard.value !== "page") {
    return (
      <button
        type="button"
        class="drive-hint link"
        data-testid="focus-hint"
        onClick={() => {
          document.querySelector<HTMLElement>("[data-testid=stick]")?.focus();
          window.focus();
        }}
      >
        <KeyboardIcon /> {t("Click here to drive with the keyboard")}
      </button>
    );
  }
  return (
    <p class="drive-hint">
      <span class="only-wide">
        {rich("Hold {keys} or arrows", { keys: <Keys names="WASD" /> })}
        {store.body.value.strafes && rich(", {keys} sideways", { keys: <Keys names="QE" /> })}
        {store.body.value.turnsHead && rich("; head: {keys}", { keys: <Keys names="IJKL" /> })}
      </span>
      <span class="only-narrow">{t("Hold and push the stick")}</span>
    </p>
  );
}

function Keys({ names }: { names: string }) {
  return [...names].map((name, at) => [at > 0 && " ", <kbd key={name}>{name}</kbd>]);
}

function speedWords({ linear_mps: linear, angular_radps: angular, lateral_mps: lateral = 0 }: Velocity): string {
  const moves = (speed: number) => Math.abs(speed) >= 0.005;
  const said = (speed: number) => ({ speed: number(Math.abs(speed), 2) });
  const words: string[] = [];
  if (moves(linear) || (moves(angular) && !moves(lateral)))
    words.push(
      t(linear < 0 ? "backward {speed} metres per second" : "forward {speed} metres per second", said(linear)),
    );
  if (moves(lateral))
    words.push(t(lateral > 0 ? "left {speed} metres per second" : "right {speed} metres per second", said(lateral)));
  if (moves(angular))
    words.push(
      t(
        angular > 0 ? "turning left {speed} radians per second" : "turning right {speed} radians per second",
        said(angular),
      ),
    );
  return words.join(", ") || t("standing");
}
