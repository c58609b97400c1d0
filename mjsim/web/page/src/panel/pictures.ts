/** Choosing a picture: of the folder, of those that come with mjsim, or one of the person's own. */

import type { Verdict } from "../api";
import type { Studio } from "../shell/view";
import { html, type View } from "../ui/view";
import { said, word } from "../words/words";
import { choose, type Entry, nameOf, ownFiles, pictured } from "./gallery";

/** So many are judged at once. */
const MOST = 200;

/** Let the person choose, and see what recognition makes of each; null when they would rather not. */
export async function choosePicture(studio: Studio): Promise<string | null> {
  const own = ownFiles(studio, studio.folder.pictures);
  const shipped = [...studio.folder.shipped.pictures].sort(postersFirst);
  const verdicts = judged(studio, [...own, ...shipped.filter(isPoster)]);
  const entry = (path: string): Entry => ({
    value: path,
    name: nameOf(path),
    about: "",
    later: verdicts.then((all) => verdictOf(all[path])),
  });
  const groups: [string, Entry[]][] = [
    [word("panel.inThisFolder"), own.map(entry)],
    [word("panel.comeWithMjsim"), shipped.map(entry)],
  ];
  return choose(
    word("panel.chooseAPicture"),
    ({ value }) => pictured(studio.api.picture(value, 160, studio.document.path)),
    groups,
    undefined,
    (answer) => dropPlace(studio, answer),
  );
}

/** Pictures that can be hung up, of the person's own and others, in the order in which they are offered. */
export function hangable(studio: Studio): string[][] {
  return [ownFiles(studio, studio.folder.pictures), studio.folder.shipped.pictures.filter(isPoster)];
}

/** What recognition makes of pictures among those of the world; nothing while the world cannot be read. */
async function judged({ api, document }: Studio, images: string[]): Promise<Record<string, Verdict>> {
  try {
    return (await api.judge(document.path ?? "", document.text, images.slice(0, MOST))).pictures;
  } catch {
    return {};
  }
}

function verdictOf(verdict: Verdict | undefined): Pick<Entry, "about" | "fault"> | null {
  if (!verdict) return null;
  const { distance, fault } = verdict;
  return fault
    ? { about: "", fault: word("panel.pictureHasAFault", { fault: said(fault) }) }
    : { about: word("panel.recognisedUpTo", { distance }) };
}

/** Bring a picture of the person's own into the folder; null when it was refused. */
export async function uploadPicture(studio: Studio, file: File): Promise<string | null> {
  try {
    const { path } = await studio.api.upload(await asPng(file), studio.document.path);
    await studio.refresh();
    return path;
  } catch (error) {
    studio.toasts.error(error);
    return null;
  }
}

/** A picture that mjsim does not read, but the browser does, as a PNG; any other file as it is. */
async function asPng(file: File): Promise<File> {
  if (["image/png", "image/jpeg"].includes(file.type)) return file;
  const bitmap = await createImageBitmap(file).catch(() => null);
  if (!bitmap) return file;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
  canvas.getContext("2d")?.drawImage(bitmap, 0, 0);
  bitmap.close();
  const blob = await new Promise<Blob | null>((done) => canvas.toBlob(done, "image/png"));
  return blob ? new File([blob], file.name.replace(/\.[^.]*$/, ".png"), { type: "image/png" }) : file;
}

function dropPlace(studio: Studio, answer: (path: string) => void): View {
  const take = async (files: FileList | null | undefined): Promise<void> => {
    const paths: string[] = [];
    for (const file of files ?? []) {
      const path = await uploadPicture(studio, file);
      if (path) paths.push(path);
    }
    if (paths[0]) answer(paths[0]);
  };
  const drop = (event: DragEvent): void => {
    event.preventDefault();
    void take(event.dataTransfer?.files);
  };
  const ask = ({ currentTarget }: Event): void =>
    (currentTarget as Element).parentElement?.querySelector("input")?.click();
  return html`<div><button type="button" class="drop" @click=${ask} @drop=${drop}
    @dragover=${(event: Event) => event.preventDefault()}>${word("panel.dropAPictureHereOr")}</button><input type="file"
    accept="image/*" multiple class="sr" tabindex="-1" aria-hidden="true"
    @change=${({ target }: Event) => take((target as HTMLInputElement).files)}></div>`;
}

function isPoster(path: string): boolean {
  return path.startsWith("posters/");
}

/** What is hung up comes before floors and walls. */
function postersFirst(one: string, other: string): number {
  return Number(isPoster(other)) - Number(isPoster(one));
}
