/** Sentences of the server: English, with the template that is their code and the values in it, for other languages. */

/** Templates and values by the English text. */
export type Sentences = Map<string, [template: string, values: Record<string, string>]>;

/** So many are known at a time: more than the largest answer has. */
const MOST = 5000;

/** Put values for their names in braces. */
export function filled(template: string, values: Record<string, string | number | null | undefined>): string {
  return template.replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
}

/** Keep the sentences that stand beside what an answer says; the oldest are forgotten. */
export function learn(sentences: Sentences, answer: unknown): void {
  const { sentences: told } = (answer ?? {}) as { sentences?: Record<string, [string, Record<string, string>]> };
  for (const [english, sentence] of Object.entries(told ?? {})) sentences.set(english, sentence);
  for (const oldest of sentences.keys()) {
    if (sentences.size <= MOST) return;
    sentences.delete(oldest);
  }
}

/** An English sentence in another language: its template is looked up, and its values, which may be sentences. */
export function spoken(english: string, known: Sentences, lookup: (template: string) => string | undefined): string {
  const [template, values] = known.get(english) ?? [null, {}];
  const words = lookup(template ?? english);
  if (words === undefined) return english;
  const names = Object.entries(values).map(([name, value]) => [name, spokenValue(value, known, lookup)]);
  // A sentence without values is its own template, in which braces are braces.
  return template === null
    ? words
    : filled(words, Object.fromEntries(names)).replaceAll("{{", "{").replaceAll("}}", "}");
}

/** Names and numbers are the same in every language. */
function spokenValue(value: string, known: Sentences, lookup: (template: string) => string | undefined): string {
  return known.has(value) || value.includes(" ") ? spoken(value, known, lookup) : value;
}
