/** Choosing a picture: of the folder, of those that come with mjsim, or one of the person's own. */

import { el, type Child } from "../dom";
import { askWith } from "../shell/dialog";
import type { Studio } from "../shell/view";
import { word } from "../words/words";

/** Let the person choose; null when they would rather not. */
export async function choosePicture(studio: Studio): Promise<string | null> {
  return askWith<string>(word("panel.chooseAPicture"), (answer) => [dropPlace(studio, answer), ...grids(studio, answer)]);
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

function dropPlace(studio: Studio, answer: (path: string) => void): HTMLElement {
  const take = async (file: File | undefined): Promise<void> => {
    const path = file && (await uploadPicture(studio, file));
    if (path) answer(path);
  };
  const input = el("input", { type: "file", accept: "image/*", class: "sr", tabindex: -1, "aria-hidden": "true" });
  input.addEventListener("change", () => void take(input.files?.[0]));
  const place = el(
    "button",
    { type: "button", class: "drop", onclick: () => input.click() },
    word("panel.dropAPictureHereOr"),
  );
  place.addEventListener("dragover", (event) => event.preventDefault());
  place.addEventListener("drop", (event) => {
    event.preventDefault();
    void take(event.dataTransfer?.files[0]);
  });
  return el("div", {}, place, input);
}

function grids(studio: Studio, answer: (path: string) => void): Child[] {
  const { pictures, shipped } = studio.folder;
  const card = (path: string): HTMLElement =>
    el(
      "button",
      { type: "button", class: "card", title: path, onclick: () => answer(path) },
      el("img", {
        src: studio.api.picture(path, 160, shipped.pictures.includes(path) ? studio.document.path : null),
        alt: "",
        loading: "lazy",
      }),
      el("span", {}, path.replace(/^.*\//, "")),
    );
  const grid = (title: string, paths: string[]): Child[] =>
    paths.length
      ? [el("p", { class: "list-title" }, title), el("div", { class: "cards pictures" }, ...paths.map(card))]
      : [];
  return [...grid(word("panel.inThisFolder"), pictures), ...grid(word("panel.comeWithMjsim"), [...shipped.pictures].sort(postersFirst))];
}

/** What is hung up comes before floors and walls. */
function postersFirst(one: string, other: string): number {
  return Number(other.startsWith("posters/")) - Number(one.startsWith("posters/"));
}
