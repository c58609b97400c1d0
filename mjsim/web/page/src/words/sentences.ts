/** Sentences of the server: English, with the template that is their code and the values in it, for other languages. */

/** Templates and values by the English text. */
export type Sentences = Map<string, [template: string, values: Record<string, string>]>;

/** More than the largest answer has. */
const MAX_KNOWN = 5000;

/** Put values for their names in braces; doubled braces are braces. */
export function filled(template: string, values: Record<string, string | number | null | undefined>): string {
  return template.replace(/\{\{|\}\}|\{(\w+)\}/g, (found, name?: string) =>
    name === undefined ? found.charAt(0) : String(values[name] ?? found),
  );
}

/** Keep the sentences beside what an answer says; those that came longest ago are forgotten. */
export function learn(sentences: Sentences, answer: unknown): void {
  const { sentences: told } = (answer ?? {}) as { sentences?: Record<string, [string, Record<string, string>]> };
  for (const [english, sentence] of Object.entries(told ?? {})) {
    sentences.delete(english);
    sentences.set(english, sentence);
  }
  for (const oldest of sentences.keys()) {
    if (sentences.size <= MAX_KNOWN) return;
    sentences.delete(oldest);
  }
}

/** An English sentence in another language: its template is looked up, and its values, which may be sentences. */
export function spoken(english: string, known: Sentences, lookup: (template: string) => string | undefined): string {
  const sentence = known.get(english);
  // A sentence without values is its own template, in which braces are braces.
  if (!sentence) return lookup(english) ?? english;
  const [template, values] = sentence;
  const words = lookup(template);
  if (words === undefined) return english;
  const names = Object.entries(values).map(([name, value]) => [name, spokenValue(value, known, lookup)]);
  return filled(words, Object.fromEntries(names));
}

/** Names and numbers are the same in every language. */
function spokenValue(value: string, known: Sentences, lookup: (template: string) => string | undefined): string {
  return known.has(value) || value.includes(" ") ? spoken(value, known, lookup) : value;
}
