/** The visible words of the page in the language that was chosen; each language is one table, looked up by key. */

import { EN } from "./en";
import { EN_FIELDS } from "./en_fields";

const ENGLISH_WORDS = { ...EN, ...EN_FIELDS };
export type Key = keyof typeof ENGLISH_WORDS;
type Words = Record<Key, string>;

const KEY = "mjsim-language";
interface Language {
  /** As its speakers call it. */
  name: string;
  /** Its table, made when it is chosen. */
  table(): Words;
}

const ENGLISH: Language = { name: "English", table: () => ENGLISH_WORDS };
/** By their BCP 47 tags. */
const LANGUAGES: Record<string, Language> = { en: ENGLISH, "en-XA": { name: "Énglísh", table: accented } };
/** Shows what is in no table: for those who write the page, offered only where it was switched on by hand. */
const FOR_DEVELOPERS = "en-XA";

/** The tag of the language of the page. */
export const language = chosen();
const words = (LANGUAGES[language] ?? ENGLISH).table();
document.documentElement.lang = language;

/** Look up words; what stands in braces there, as {path}, is replaced by the value of that name. */
export function word(key: Key, values: Record<string, string | number | null | undefined> = {}): string {
  return words[key].replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
}

/**
 * Look up what the data calls by a key: a field, a form of its value, a kind of thing. What has no entry, such as the
 * options of somebody's own module, is made from the key: `max_speed` becomes "Max speed" in every language.
 */
export function wordFor(kind: "field" | "form" | "item" | "part", key: string, values: Record<string, number> = {}): string {
  const known = `${kind}.${key}`;
  if (known in words) return word(known as Key, values);
  const plain = key.replace(/([a-z])([A-Z])/g, "$1 $2").replaceAll("_", " ").toLowerCase();
  return plain.charAt(0).toUpperCase() + plain.slice(1);
}

/** The languages that a person can choose: tag and name. */
export function offered(): [tag: string, name: string][] {
  const tags = Object.keys(LANGUAGES).filter((tag) => tag !== FOR_DEVELOPERS || tag === language);
  return tags.map((tag) => [tag, LANGUAGES[tag]?.name ?? tag]);
}

/** Use another language from the next load of the page on. */
export function choose(tag: string): void {
  window.localStorage.setItem(KEY, tag);
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
  return Object.fromEntries(Object.entries(ENGLISH_WORDS).map(([key, text]) => [key, `[${change(text)}~]`])) as Words;
}
