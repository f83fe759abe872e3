/** Chooses the page's language: in the layout's menu, on the sheet of shortcuts, which phones have too, and at the login. */

import { useApp } from "../state/context";
import { chooseLanguage, thisReader } from "./language";
import { LANGUAGES, type Language, shown, t } from "./text";

export function LanguageChoice() {
  const { store } = useApp();
  const choose = async (language: Language) => {
    try {
      await chooseLanguage(language, thisReader());
    } catch (error) {
      store.notify("error", t("The language could not be loaded: {problem}", { problem: String(error) }));
    }
  };
  return (
    <label class="layout-theme">
      {t("Language")}
      <select
        value={shown.value.language}
        data-testid="language"
        onChange={(event) => void choose(event.currentTarget.value as Language)}
      >
        {/* Each by its own name, for those who read no other. */}
        {Object.entries(LANGUAGES).map(([tag, name]) => (
          <option key={tag} value={tag} lang={tag}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}
