/** The visible words of the page in the language that was chosen; each language is one table, looked up by key. */

import { EN } from "./en";
import { EN_FIELDS } from "./en_fields";
import { EN_SERVER } from "./en_server";
import { filled, learn, type Sentences, spoken } from "./sentences";

const ENGLISH_WORDS = { ...EN, ...EN_FIELDS, ...EN_SERVER };
export type Key = keyof typeof ENGLISH_WORDS;
export type Words = Record<Key, string>;

const KEY = "mjsim-language";
/** Of the address of the page: ?lang=en-XA chooses a language. */
const PARAMETER = "lang";
/** The tables of other languages, as a program of its own. */
const PROGRAM = "/languages.js";
/** Whole languages by their BCP 47 tags, as their speakers call them. */
const LANGUAGES: Record<string, string> = { en: "English", "en-XA": "Énglísh" };
/** Shows what is in no table: for those who write the page, offered only where it was switched on by hand. */
const FOR_DEVELOPERS = "en-XA";

const wanted = chosen();
// Without them the page is there in English.
const others =
  wanted === "en" ? null : await (import(PROGRAM) as Promise<typeof import("./languages")>).catch(() => null);
/** The tag of the language of the page. */
export const language = others ? wanted : "en";
const words: Record<string, string> = others?.tableOf(language, ENGLISH_WORDS) ?? ENGLISH_WORDS;
document.documentElement.lang = language;

/** Look up words; what stands in braces there, as {path}, is replaced by the value of that name. */
export function word(key: Key, values: Record<string, string | number | null | undefined> = {}): string {
  return filled(words[key] ?? key, values);
}

/**
 * Look up what the data calls by a key: a field, a form of its value, a kind of thing. What has no entry, such as the
 * options of somebody's own module, is made from the key: `max_speed` becomes "Max speed" in every language.
 */
export function wordFor(
  kind: "field" | "form" | "item" | "part",
  key: string,
  values: Record<string, number> = {},
): string {
  const known = `${kind}.${key}`;
  if (known in words) return word(known as Key, values);
  const plain = key
    .replace(/([a-z])([A-Z])/g, "$1 $2")
    .replaceAll("_", " ")
    .toLowerCase();
  return plain.charAt(0).toUpperCase() + plain.slice(1);
}

/** Look up what the data calls by a key of a kind: a figure, a statistic, an event; `otherwise` where it has no entry. */
export function wordOr(kind: "figure" | "statistic" | "event", key: string, otherwise: string): string {
  const known = `${kind}.${key}`;
  return known in words ? word(known as Key) : otherwise;
}

/** Learn what the sentences in an answer of the server were made of, and return the answer. */
export function heard<T>(answer: T): T {
  if (others) learn(sentences, answer);
  return answer;
}

/** What the server said in English, in the language of the page; what is not in its table stays as it is. */
export function said(english: string): string {
  return others ? spoken(english, sentences, (template) => others.sentenceIn(language, template)) : english;
}

const sentences: Sentences = new Map();

/** The meaning of a field in the language of the page; `english` is the sentence of the schema. */
export function meaningOf(english: string): string {
  return (english && others?.meaningIn(language, english)) || english;
}

/** The languages that a person can choose: tag and name. */
export function offered(): [tag: string, name: string][] {
  return Object.entries(LANGUAGES).filter(([tag]) => tag !== FOR_DEVELOPERS || tag === language);
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
  return navigator.languages.map(known).find((tag) => tag !== null) ?? "en";
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
