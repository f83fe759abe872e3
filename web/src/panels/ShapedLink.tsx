/** In the bar: a link that is shaped must not be taken for the network's own. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { WarnIcon } from "../ui/icons";

export function ShapedLink() {
  const text = useApp().store.of("link").value?.text;
  if (!text) return null;
  return (
    <p
      class="chip warn link-shaped"
      role="status"
      data-testid="link-shaped"
      title={t("Link shaped for tests: {text}", { text })}
    >
      <WarnIcon />
      <span>
        {t("Link shaped")}
        <span class="roomy">: {text}</span>
      </span>
    </p>
  );
}
