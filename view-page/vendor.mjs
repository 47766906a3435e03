// Bundles three.js and uPlot into ecs_eco/view/static/vendor.js and vendor.css; with --check compares instead of writing.
import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";

const here = new URL(".", import.meta.url);
const target = new URL("../ecs_eco/view/static/", here);
const notices = [];
for (const name of ["three", "uplot"]) {
  const { version } = JSON.parse(await readFile(new URL(`node_modules/${name}/package.json`, here), "utf8"));
  const license = await readFile(new URL(`node_modules/${name}/LICENSE`, here), "utf8");
  notices.push(`${name} ${version}\n\n${license.trim()}`);
}
const banner = `/*!\nMade by view-page/vendor.mjs; not edited by hand.\n\n${notices.join("\n\n----\n\n")}\n*/`;

const common = { bundle: true, minify: true, write: false, legalComments: "none", absWorkingDir: new URL(".", here).pathname };
const [script] = (await build({ ...common, entryPoints: ["vendor-entry.js"], format: "esm", target: "es2022", banner: { js: banner } })).outputFiles;
const [style] = (await build({ ...common, entryPoints: ["node_modules/uplot/dist/uPlot.min.css"], banner: { css: banner } })).outputFiles;

let stale = false;
for (const [name, made] of [["vendor.js", script], ["vendor.css", style]]) {
  const file = new URL(name, target);
  if (process.argv.includes("--check")) {
    const kept = await readFile(file, "utf8").catch(() => "");
    if (kept !== made.text) {
      console.error(`ecs_eco/view/static/${name} is out of date: run "npm run vendor" in view-page`);
      stale = true;
    }
  } else {
    await writeFile(file, made.text);
    console.log(`${name}: ${(made.text.length / 1024).toFixed(0)} KiB`);
  }
}
process.exit(stale ? 1 : 0);
