/** What draws the pictures in 3-D. */

/** What draws the pictures, by its own name. Raises Error with `refusal` when nothing does. */
export function drawnBy(refusal: string): string {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) throw new Error(refusal);
  const known = context.getExtension("WEBGL_debug_renderer_info");
  const name = known ? String(context.getParameter(known.UNMASKED_RENDERER_WEBGL)) : "";
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return name;
}

/** Whether pictures are drawn by the processor, where smooth edges cost most of the time. */
export function isSlow(name: string): boolean {
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
