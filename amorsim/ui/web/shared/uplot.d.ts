// deno-lint-ignore-file no-explicit-any -- uPlot, as far as the type checker is concerned.
declare const uPlot: any;
export default uPlot;
