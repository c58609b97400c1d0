/** Tables of languages other than English; fetched by the page only when one of them is chosen. */

type Table = Record<string, string>;

/** By their tags; only whole ones are offered. */
const TABLES: Record<string, { table: Table; meanings: Table; sentences: Table }> = {};
/** Shows what is in no table. */
const ACCENTED = "en-XA";

/** The words of a language; those that it lacks are English. */
export function tableOf(tag: string, english: Table): Table {
  if (tag === ACCENTED) return Object.fromEntries(Object.entries(english).map(([key, text]) => [key, accent(text)]));
  return { ...english, ...TABLES[tag]?.table };
}

/** The meaning of a field, by its English sentence; undefined where a language lacks it. */
export function meaningIn(tag: string, english: string): string | undefined {
  return tag === ACCENTED ? accent(english) : own(TABLES[tag]?.meanings, english);
}

/** A sentence of the server, by its English template; undefined where a language lacks it. */
export function sentenceIn(tag: string, template: string): string | undefined {
  return tag === ACCENTED ? accent(template) : own(TABLES[tag]?.sentences, template);
}

/** What a table itself has: any text is looked up, "constructor" too. */
function own(table: Table | undefined, text: string): string | undefined {
  return table && Object.hasOwn(table, text) ? table[text] : undefined;
}

/** English with accents, in brackets and longer: what stays plain is in no table, what is cut off has no room. */
function accent(text: string): string {
  const accents: Table = { a: "á", e: "é", i: "í", o: "ó", u: "ú", A: "Á", E: "É", I: "Í", O: "Ó", U: "Ú" };
  return `[${text.replace(/\{\w+\}|[aeiou]/gi, (part) => accents[part] ?? part)}~]`;
}
