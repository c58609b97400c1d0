/** The numbers of a recording, each asked for once. */

import { titleOf } from "../charts/layouts";
import type { Column, Field, Message, Source } from "../charts/plotter";
import { recordings } from "./recording";

export class RecordedNumbers implements Source {
  private readonly asked = new Map<string, Promise<Column>>();

  constructor(private readonly path: () => string) {}

  /** There is another recording. */
  clear(): void {
    this.asked.clear();
  }

  fields(): ReturnType<Source["fields"]> {
    return recordings.fields(this.path());
  }

  message(topic: string, time: number | null): Promise<Message | null> {
    return recordings.message(this.path(), topic, time ?? 0);
  }

  column(field: Field): Promise<Column> {
    const title = titleOf(field);
    const found = this.asked.get(title);
    if (found) return found;
    const answer = recordings.column(this.path(), field);
    this.asked.set(title, answer);
    // One that did not come is asked for again.
    answer.catch(() => this.asked.delete(title));
    return answer;
  }
}
