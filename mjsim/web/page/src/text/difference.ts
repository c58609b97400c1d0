/** The one stretch in which two texts differ; no letter that takes two places is parted. */
export function difference(old: string, fresh: string): { from: number; to: number; insert: string } {
  const most = Math.min(old.length, fresh.length);
  let from = 0;
  while (from < most && old[from] === fresh[from]) from++;
  if (from > 0 && isFirstHalf(old, from - 1)) from--;
  let behind = 0;
  while (behind < most - from && old[old.length - 1 - behind] === fresh[fresh.length - 1 - behind]) behind++;
  if (behind > 0 && isSecondHalf(old, old.length - behind)) behind--;
  return { from, to: old.length - behind, insert: fresh.slice(from, fresh.length - behind) };
}

function isFirstHalf(text: string, at: number): boolean {
  return (text.charCodeAt(at) & 0xfc00) === 0xd800;
}

function isSecondHalf(text: string, at: number): boolean {
  return (text.charCodeAt(at) & 0xfc00) === 0xdc00;
}
