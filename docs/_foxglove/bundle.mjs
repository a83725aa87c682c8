// Makes page.js and the renderer one script that a page without a server can load: bundle.js.
import * as esbuild from "esbuild";

// Packages that Foxglove never published, and decoders of meshes; markers need none of their
// functions but two: loggers, and the map of transforms, which has one entry.
const MISSING = /^(fs|path|@foxglove\/(log|den\/.*)|.*\/draco_.*)$/;
const unused = ["MultiMap", "PinholeCameraModel", "filterMap", "parseRobot", "decodeBGR8",
  "decodeBGRA8", "decodeBayerBGGR8", "decodeBayerGBRG8", "decodeBayerGRBG8", "decodeBayerRGGB8",
  "decodeFloat1c", "decodeMono16", "decodeMono8", "decodeRGB8", "decodeRGBA8", "decodeYUV",
  "decodeYUYV"];
const contents = `
  export default { getLogger: () => console };
  export class ArrayMap extends Map { maxEntry() { return [...this].pop(); } }
  ${unused.map((name) => `export class ${name} {}`).join("\n")}`;

const packages = {
  name: "packages",
  setup(build) {
    build.onResolve({ filter: MISSING }, ({ path }) => ({ path, namespace: "missing" }));
    build.onLoad({ filter: /.*/, namespace: "missing" }, () => ({ contents }));
    build.onResolve({ filter: /^three\/(examples|src)\/[^.]*$/ }, ({ path, ...from }) =>
      build.resolve(`${path}.js`, { resolveDir: from.resolveDir, kind: from.kind }));
  },
};

await esbuild.build({
  entryPoints: ["page.js"], outfile: "bundle.js", bundle: true, format: "iife",
  plugins: [packages], logLevel: "error",
  loader: { ".png": "dataurl", ".svg": "text", ".wasm": "binary", ".woff2": "dataurl" },
  define: { __filename: '""', global: "window", "process.env.NODE_ENV": '"production"', ReactNull: "null" },
});
