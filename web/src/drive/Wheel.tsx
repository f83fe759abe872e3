/** Asking for the wheel, and being asked for it: shown over every layout, on every tab. */

import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { WheelIcon } from "../ui/icons";

export function WheelAsked() {
  const { store, session } = useApp();
  const status = store.of("status").value;
  const asker = store.live.value ? (status?.asker ?? null) : null;
  const driver = status?.driver ?? null;
  const given = useRef<HTMLButtonElement>(null);
  const asked = asker !== null && driver?.mine === true;
  useEffect(() => {
    // Not the focus: a key that is held, or Enter, must not give the wheel away.
    if (asked) given.current?.blur();
  }, [asked]);
  if (!asker || !driver || (!asker.mine && !driver.mine)) return null;
  const left = Math.ceil(asker.remaining_s);
  if (asker.mine)
    return (
      <div class="wheel-asked" role="status" data-testid="wheel-waits">
        <WheelIcon />
        <p>
          <b>{t("Asking {name} for the wheel…", { name: driver.operator })}</b>
          <span aria-hidden="true">{left} s</span>
        </p>
      </div>
    );
  const answer = (give: boolean) => () => session.send({ type: "answer_control", give });
  return (
    <div
      class="wheel-asked"
      role="alertdialog"
      aria-label={t("{operator} asks for the wheel", { operator: asker.operator })}
      data-testid="wheel-asked"
    >
      <WheelIcon />
      <p>
        <b>{t("{operator} asks for the wheel", { operator: asker.operator })}.</b>
        <span>{driver.holds ? t("While you hold on, you keep it.") : t("Without an answer it is theirs.")}</span>
      </p>
      <button type="button" class="button" ref={given} data-testid="wheel-give" onClick={answer(true)}>
        {t("Give it")}
      </button>
      <button type="button" class="button accent" data-testid="wheel-keep" onClick={answer(false)}>
        {t("Keep it")} <span aria-hidden="true">({left} s)</span>
      </button>
    </div>
  );
}

/** Who has the wheel, where that is another; and what this role may do about it. */
export function WheelOfAnother({ name }: { name: string }) {
  const { store, session } = useApp();
  const { role } = store;
  const asks = store.of("status").value?.asker?.mine === true;
  if (role.value === "spectator") return <p class="drive-hint">{t("{name} has the wheel.", { name })}</p>;
  return (
    <div class="wheel-buttons">
      <button
        type="button"
        class="button accent"
        data-testid="ask-control"
        disabled={asks}
        onClick={() => session.send({ type: "ask_control" })}
      >
        <WheelIcon /> {asks ? t("Asking {name}…", { name }) : t("Ask {name} for the wheel", { name })}
      </button>
      {role.value === "supervisor" && (
        <button
          type="button"
          class="button quiet"
          data-testid="take-control"
          onClick={() => session.send({ type: "take_control" })}
        >
          {t("Take over")}
        </button>
      )}
    </div>
  );
}
