/** The visible words of the page in the language that was chosen; each language is one table, looked up by key. */

import { DE } from "./de";
import { DE_MEANINGS } from "./de_meanings";
import { EN } from "./en";
import { EN_FIELDS } from "./en_fields";

const ENGLISH_WORDS = { ...EN, ...EN_FIELDS };
export type Key = keyof typeof ENGLISH_WORDS;
export type Words = Record<Key, string>;

const KEY = "mjsim-language";
/** Of the address of the page: ?lang=de chooses a language. */
const PARAMETER = "lang";
interface Language {
  /** As its speakers call it. */
  name: string;
  /** Its table, made when it is chosen; a word that is missing there is shown in English. */
  table(): Partial<Words>;
  /** The meaning of a field, by its English sentence; one that is missing there is shown in English. */
  meaning(english: string): string | undefined;
}

/** By their BCP 47 tags. */
const LANGUAGES: Record<string, Language> = {
  en: { name: "English", table: () => ENGLISH_WORDS, meaning: (english) => english },
  de: { name: "Deutsch", table: () => DE, meaning: (english) => DE_MEANINGS[english] },
  "en-XA": { name: "Énglísh", table: accented, meaning: accent },
};
/** Shows what is in no table: for those who write the page, offered only where it was switched on by hand. */
const FOR_DEVELOPERS = "en-XA";

/** The tag of the language of the page. */
export const language = chosen();
const words: Words = { ...ENGLISH_WORDS, ...LANGUAGES[language]?.table() };
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

/** The meaning of a field in the language of the page; `english` is the sentence of the schema. */
export function meaningOf(english: string): string {
  return (english && LANGUAGES[language]?.meaning(english)) || english;
}

/** The languages that a person can choose: tag and name, with the share that is translated where that is not all. */
export function offered(): [tag: string, name: string][] {
  return Object.entries(LANGUAGES)
    .filter(([tag]) => tag !== FOR_DEVELOPERS || tag === language)
    .map(([tag, { name, table }]) => {
      const share = Object.keys(table()).length / Object.keys(ENGLISH_WORDS).length;
      return [tag, share < 1 ? `${name} (${Math.max(Math.floor(100 * share), 1)} %)` : name];
    });
}

/** Use another language from the next load of the page on. */
export function choose(tag: string): void {
  window.localStorage.setItem(KEY, tag);
}

/** What the address asks for, what the browser remembers, or what its user reads; English where there is none of them. */
function chosen(): string {
  const asked = askedFor();
  if (asked !== null) return asked;
  const kept = remembered();
  if (kept !== null && Object.hasOwn(LANGUAGES, kept)) return kept;
  return navigator.languages.map(known).find((tag) => tag !== null && isComplete(tag)) ?? "en";
}

/** The language in the address, which is remembered in its place: so another one can be chosen afterwards. */
function askedFor(): string | null {
  const address = new URL(window.location.href);
  const given = address.searchParams.get(PARAMETER);
  if (given === null) return null;
  address.searchParams.delete(PARAMETER);
  window.history.replaceState(window.history.state, "", address);
  const tag = known(given);
  try {
    if (tag !== null) choose(tag);
  } catch {
    // A browser that keeps nothing has it until the page is loaded again.
  }
  return tag;
}

function remembered(): string | null {
  try {
    return window.localStorage.getItem(KEY);
  } catch {
    // A browser that keeps nothing is one that has not chosen.
    return null;
  }
}

/** The language of a tag such as de-AT, or that which it is a form of; null where there is no table. */
function known(tag: string): string | null {
  const [base = ""] = tag.split("-");
  return [tag, base].find((each) => Object.hasOwn(LANGUAGES, each)) ?? null;
}

/** Nobody is given half a translation who did not ask for it. */
function isComplete(tag: string): boolean {
  return Object.keys(LANGUAGES[tag]?.table() ?? {}).length === Object.keys(ENGLISH_WORDS).length;
}

/** English with accents, in brackets and longer: what stays plain is in no table, what is cut off has no room. */
function accented(): Words {
  return Object.fromEntries(Object.entries(ENGLISH_WORDS).map(([key, text]) => [key, accent(text)])) as Words;
}

function accent(text: string): string {
  const accents: Record<string, string> = { a: "á", e: "é", i: "í", o: "ó", u: "ú", A: "Á", E: "É", I: "Í", O: "Ó", U: "Ú" };
  return `[${text.replace(/\{\w+\}|[aeiou]/gi, (part) => accents[part] ?? part)}~]`;
}
