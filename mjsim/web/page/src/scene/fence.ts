/** Commands of WebGL return before they are carried out: a fence tells when the pictures they draw are there. */

/** It is looked so often whether a picture is there [ms]. */
const OFTEN = 2;

/** Call `then` once all commands given until now are carried out, or never will be; meanwhile the page goes on. */
export function whenDrawn(context: WebGL2RenderingContext, then: () => void): void {
  const fence = context.fenceSync(context.SYNC_GPU_COMMANDS_COMPLETE, 0);
  if (!fence) return then();
  context.flush();
  const look = (): void => {
    if (context.clientWaitSync(fence, 0, 0) === context.TIMEOUT_EXPIRED) return void window.setTimeout(look, OFTEN);
    context.deleteSync(fence);
    then();
  };
  window.setTimeout(look, OFTEN);
}
