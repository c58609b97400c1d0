/** Tables of languages other than English; fetched by the page only when one of them is chosen. */

import { EN_SAID } from "./en_said";

type Table = Record<string, string>;

/** By their tags; only whole ones are offered. */
const TABLES: Record<string, { table: Table; meanings: Table }> = {};
/** Shows what is in no table. */
const ACCENTED = "en-XA";

/** The words of a language; those that it lacks are English. */
export function tableOf(tag: string, english: Table): Table {
  const whole = { ...english, ...EN_SAID };
  if (tag === ACCENTED) return Object.fromEntries(Object.entries(whole).map(([key, text]) => [key, accent(text)]));
  return { ...whole, ...TABLES[tag]?.table };
}

/** The meaning of a field, by its English sentence; undefined where a language lacks it. */
export function meaningIn(tag: string, english: string): string | undefined {
  return tag === ACCENTED ? accent(english) : TABLES[tag]?.meanings[english];
}

/** English with accents, in brackets and longer: what stays plain is in no table, what is cut off has no room. */
function accent(text: string): string {
  const accents: Table = { a: "á", e: "é", i: "í", o: "ó", u: "ú", A: "Á", E: "É", I: "Í", O: "Ó", U: "Ú" };
  return `[${text.replace(/\{\w+\}|[aeiou]/gi, (part) => accents[part] ?? part)}~]`;
}

/** What the server says, by keys: sentences with most words of their own first. */
export function sentences(): [key: string, pattern: RegExp][] {
  const own = (text: string): number => text.replace(/\{\w+\}/g, "").length;
  const pattern = (text: string): string =>
    text.replace(/[\\^$.*+?()[\]|]/g, "\\$&").replace(/\{(\w+)\}/g, "(?<$1>.*?)");
  return Object.entries(EN_SAID)
    .sort(([, a], [, b]) => own(b) - own(a))
    .map(([key, text]) => [key, new RegExp(`^${pattern(text)}$`, "s")]);
}
