/** Giving files to the browser's downloads. */

import { el } from "../ui/dom";

export function save(blob: Blob, name: string): void {
  const link = el("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  // The browser reads it after this.
  window.setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Rows of cells as CSV; what has commas, quotes or new lines in it is quoted. */
export function csvOf(rows: (string | number | null | undefined)[][]): string {
  const cell = (value: string | number | null | undefined): string => {
    const text = String(value ?? "");
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [...rows.map((row) => row.map(cell).join(",")), ""].join("\n");
}
