/** The page in the reader's language. */

export { type FieldFault, faultWords, fromRobot, langOf, named, saysRule, spaceBetween } from "./robot";
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
