/** Notices to this viewer: short, dismissable, gone by themselves. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { CloseIcon, WarnIcon } from "./icons";

export function Notices() {
  const { store } = useApp();
  return (
    <div class="notices" role="log" aria-live="polite" aria-label={t("Notices")}>
      {store.notices.value.map((notice) => (
        <div key={notice.id} class={`notice ${notice.level}`} data-testid="notice" data-level={notice.level}>
          {notice.level !== "info" && <WarnIcon />}
          <p lang={notice.lang}>{notice.text}</p>
          <button type="button" class="icon-button" aria-label={t("Dismiss")} onClick={() => store.dismiss(notice.id)}>
            <CloseIcon />
          </button>
        </div>
      ))}
    </div>
  );
}
