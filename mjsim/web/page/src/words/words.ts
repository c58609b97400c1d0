/** The visible words of the page in the language that was chosen; each language is one table, looked up by key. */

import { EN } from "./en";

export type Key = keyof typeof EN;
type Words = Record<Key, string>;

const KEY = "mjsim-language";
/** A language is its table, made when it is chosen. */
const LANGUAGES: Record<string, () => Words> = { en: () => EN, "en-XA": accented };

const language = chosen();
const words = (LANGUAGES[language] ?? LANGUAGES["en"] ?? ((): Words => EN))();
document.documentElement.lang = language;

/** Look up words; what stands in braces there, as {path}, is replaced by the value of that name. */
export function word(key: Key, values: Record<string, string | number | null | undefined> = {}): string {
  return words[key].replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
}

/** What the browser remembers, where there is such a language; English else. */
function chosen(): string {
  try {
    const kept = window.localStorage.getItem(KEY) ?? "en";
    return kept in LANGUAGES ? kept : "en";
  } catch {
    // A browser that keeps nothing is one that has not chosen.
    return "en";
  }
}

/** English with accents, in brackets and longer: what stays plain is in no table, what is cut off has no room. */
function accented(): Words {
  const accents: Record<string, string> = { a: "á", e: "é", i: "í", o: "ó", u: "ú", A: "Á", E: "É", I: "Í", O: "Ó", U: "Ú" };
  const change = (text: string): string => text.replace(/\{\w+\}|[aeiou]/gi, (part) => accents[part] ?? part);
  return Object.fromEntries(Object.entries(EN).map(([key, text]) => [key, `[${change(text)}~]`])) as Words;
}
