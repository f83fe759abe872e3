/** The page in the reader's language. */

export {
  decimals,
  LANGUAGES,
  type Language,
  listed,
  named,
  type PluralText,
  plural,
  rich,
  shown,
  type Text,
  t,
  within,
} from "./text";
