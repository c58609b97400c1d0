/** Paths of the folder, as worlds and the server write them. */

/** The path of a file that stands so beside a world; `..` leads out of the world's folder. */
export function beside(world: string | null, file: string): string {
  const [scheme, path] = /^(shipped:)?(.*)$/.exec(world ?? "")?.slice(1) ?? [];
  const steps = [...(path ?? "").split("/").slice(0, -1), ...file.split("/")];
  const kept: string[] = [];
  for (const step of steps) {
    if (step === ".." && kept.length && kept.at(-1) !== "..") kept.pop();
    else if (step !== "." && step !== "") kept.push(step);
  }
  return (scheme ?? "") + kept.join("/");
}

/** How a world names a file of the folder. */
export function seenFrom(world: string | null, file: string): string {
  const from = (world ?? "")
    .replace(/^shipped:/, "")
    .split("/")
    .slice(0, -1);
  const to = file.split("/");
  let same = 0;
  while (same < from.length && same < to.length - 1 && from[same] === to[same]) same++;
  return [...from.slice(same).map(() => ".."), ...to.slice(same)].join("/");
}
