/** The page in the reader's language. */

export { fromRobot, langOf, named, spaceBetween } from "./robot";
export {
  decimals,
  LANGUAGES,
  type Language,
  listed,
  type PluralText,
  plural,
  rich,
  shown,
  type Text,
  t,
  within,
} from "./text";
