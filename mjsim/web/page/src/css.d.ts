/** Style sheets are bundled by esbuild. */
declare module "*.css";
declare module "*.glsl" {
  const program: string;
  export default program;
}
