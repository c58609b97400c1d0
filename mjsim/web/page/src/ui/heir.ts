/** What has the focus after a control that is gone. */

/** What stands now where the control `index` of those before was: behind the last one before it that is still there. */
export function heirOf<T>(before: T[], index: number, now: T[]): T | undefined {
  const last = before.slice(0, index).findLast((each) => now.includes(each));
  return now[last === undefined ? 0 : now.indexOf(last) + 1] ?? now.at(-1);
}
