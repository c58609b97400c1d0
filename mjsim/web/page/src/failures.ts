/** What becomes of a request that fails: who waits for it handles it, and of the others the person is told. */

import type { Values } from "./api";

/** The server said no, or could not be reached (status 0); the message is for people. */
export class ApiError extends Error {
  readonly status: number;
  readonly data: Values;

  constructor(status: number, message: string, data: Values = {}) {
    super(message);
    this.status = status;
    this.data = data;
  }
}

/** Tell of requests whose failure nobody handles; an error of the page itself stays unhandled, for whoever mends it. */
export function tellUnhandled(page: Pick<Window, "addEventListener">, tell: (error: ApiError) => void): void {
  page.addEventListener("unhandledrejection", (event) => {
    if (!(event.reason instanceof ApiError)) return;
    event.preventDefault();
    tell(event.reason);
  });
}
