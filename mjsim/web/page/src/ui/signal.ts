/** Telling others: who wants to know subscribes, and gets back how to stop. */
export class Signal<T = void> {
  private readonly listeners = new Set<(value: T) => void>();

  on(listener: (value: T) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  emit(value: T): void {
    for (const listener of [...this.listeners]) listener(value);
  }
}

/** Call once things have been quiet for so long [ms]; `now` calls at once when a call is due. */
export function debounced(work: () => void, quiet: number): { (): void; now(): void } {
  let timer: number | undefined;
  const run = (): void => {
    timer = undefined;
    work();
  };
  const call = (): void => {
    window.clearTimeout(timer);
    timer = window.setTimeout(run, quiet);
  };
  call.now = (): void => {
    if (timer === undefined) return;
    window.clearTimeout(timer);
    run();
  };
  return call;
}

/** Call so long [ms] after the first of several wishes, also while more of them come; `now` calls at once when one is due. */
export function throttled(work: () => void, wait: number): { (): void; now(): void } {
  let timer: number | undefined;
  const run = (): void => {
    window.clearTimeout(timer);
    timer = undefined;
    work();
  };
  const call = (): void => {
    timer ??= window.setTimeout(run, wait);
  };
  call.now = (): void => {
    if (timer !== undefined) run();
  };
  return call;
}

/**
 * Do one piece of work at a time; of those asked for meanwhile only the newest is done. What it returns ends when
 * nothing is left to do.
 */
export function newestWins<T>(work: (wanted: T) => Promise<void>): (wanted: T) => Promise<void> {
  let busy: Promise<void> | null = null;
  let next: { wanted: T } | null = null;
  const all = async (): Promise<void> => {
    try {
      while (next) {
        const { wanted }: { wanted: T } = next;
        next = null;
        await work(wanted);
      }
    } finally {
      busy = null;
    }
  };
  return (wanted: T): Promise<void> => {
    next = { wanted };
    return (busy ??= all());
  };
}
