// Each way in: what a bundler makes is run, in node and in headless Chromium. `tests/web.sh` puts the packed package beside it.
//
// Needs Debian's `chromium`. Without it the tests in a browser say that they are skipped; with `TRISAP_NO_SKIP` set, they fail.

import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const HERE = fileURLToPath(new URL(".", import.meta.url));
const RIGHT = "pairs 0,1";
const PATIENCE = 120_000;
const PAGE = (script) => `<!doctype html><meta charset="utf-8"><title>trisap</title><script type="module" src="${script}"></script>`;
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };
const installed = spawnSync("chromium", ["--version"]).status === 0;
const skip = !installed && !process.env.TRISAP_NO_SKIP ? "skipped: chromium is not installed" : false;

/** A folder for what is built, away from the package. */
async function folder(t) {
  const path = await mkdtemp(join(tmpdir(), "trisap-bundlers-"));
  t.after(() => rm(path, { recursive: true, force: true, maxRetries: 5 }));
  return path;
}

/** What the page of a server says that it has seen. */
async function visit(t, address, seen) {
  const profile = await folder(t);
  const flags = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", `--user-data-dir=${profile}`, address];
  const child = spawn("chromium", flags, { stdio: "ignore" });
  const gone = new Promise((resolve) => child.on("exit", resolve));
  let timer;
  const late = new Promise((_, reject) => (timer = setTimeout(() => reject(new Error("the page says nothing")), PATIENCE)));
  try {
    return await Promise.race([seen, late]);
  } finally {
    clearTimeout(timer);
    child.kill();
    await gone;
  }
}

/** Hears what a page posts. */
function ear() {
  let tell;
  const seen = new Promise((resolve) => (tell = resolve));
  const hear = async (request, response) => {
    let body = "";
    for await (const chunk of request) {
      body += chunk;
    }
    response.end();
    tell(body);
  };
  return { seen, hear };
}

/** Serves a folder to a browser. */
async function browse(t, root) {
  const { seen, hear } = ear();
  const server = createServer(async (request, response) => {
    if (request.url === "/seen") {
      return hear(request, response);
    }
    const path = request.url === "/" ? "/index.html" : request.url;
    const bytes = await readFile(join(root, path)).catch(() => null);
    response.writeHead(bytes === null ? 404 : 200, { "content-type": TYPES[extname(path)] ?? "text/plain" }).end(bytes);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  t.after(() => (server.closeAllConnections(), server.close()));
  return visit(t, `http://127.0.0.1:${server.address().port}/`, seen);
}

test("node: import, and require", async () => {
  const ask = (type, load) =>
    execFileSync(process.execPath, [`--input-type=${type}`, "-e", `${load}import("./program.js").then(({ tell }) => tell(createWorld))`], { cwd: HERE });
  assert.equal(String(ask("module", 'import { createWorld } from "trisap";')).trim(), RIGHT);
  assert.equal(String(ask("commonjs", 'const { createWorld } = require("trisap");')).trim(), RIGHT);
});

test("Deno and Bun run it as it is", () => {
  for (const [host, ...flags] of [["deno", "run", "--allow-read"], ["bun", "run"]]) {
    for (const program of ["by-url.js", "inline.js"]) {
      const said = execFileSync(`${HERE}node_modules/.bin/${host}`, [...flags, program], { cwd: HERE });
      assert.equal(String(said).trim(), RIGHT, `${host} ${program}`);
    }
  }
});

test("esbuild: one file, for node and for a browser", async (t) => {
  const { build } = await import("esbuild");
  const out = await folder(t);
  await build({ entryPoints: [`${HERE}inline.js`], bundle: true, platform: "node", format: "esm", outfile: `${out}/node.mjs` });
  assert.equal(String(execFileSync(process.execPath, [`${out}/node.mjs`], { cwd: out })).trim(), RIGHT);
  // Without its module beside it the package says what to do.
  await build({ entryPoints: [`${HERE}by-url.js`], bundle: true, platform: "node", format: "esm", outfile: `${out}/lost.mjs` });
  assert.match(String(execFileSync(process.execPath, [`${out}/lost.mjs`], { cwd: out })), /ModuleError.*trisap\/inline/);
});

test("esbuild: a page, and a worker from a blob", { skip }, async (t) => {
  const { build } = await import("esbuild");
  const out = await folder(t);
  await build({ entryPoints: [`${HERE}inline.js`], bundle: true, format: "iife", outfile: `${out}/worker.js` });
  await writeFile(`${out}/index.html`, PAGE("page.js"));
  await writeFile(`${out}/page.js`, `
    const blob = new Blob([await (await fetch("worker.js")).text()], { type: "text/javascript" });
    const worker = new Worker(URL.createObjectURL(blob));
    worker.onerror = (event) => fetch("/seen", { method: "POST", body: event.message });
    worker.onmessage = ({ data }) => fetch("/seen", { method: "POST", body: data });`);
  assert.equal(await browse(t, out), RIGHT);
});

test("rollup: one file in a page", { skip }, async (t) => {
  const [{ rollup }, { nodeResolve }] = await Promise.all([import("rollup"), import("@rollup/plugin-node-resolve")]);
  const out = await folder(t);
  const bundle = await rollup({ input: `${HERE}inline.js`, plugins: [nodeResolve({ browser: true })] });
  await bundle.write({ file: `${out}/page.js`, format: "es" });
  await writeFile(`${out}/index.html`, PAGE("page.js"));
  assert.equal(await browse(t, out), RIGHT);
});

test("webpack finds the modules", { skip }, async (t) => {
  const { default: webpack } = await import("webpack");
  const out = await folder(t);
  const config = { mode: "production", context: HERE, entry: "./by-url.js", output: { path: out, filename: "page.js", publicPath: "/" } };
  const stats = await new Promise((resolve, reject) => webpack(config, (error, stats) => (error ? reject(error) : resolve(stats))));
  assert.ok(!stats.hasErrors(), stats.toString());
  await writeFile(`${out}/index.html`, PAGE("page.js"));
  assert.equal(await browse(t, out), RIGHT);
});

test("vite finds the modules, in a build and in development", { skip }, async (t) => {
  const { build, createServer: develop } = await import("vite");
  const out = await folder(t);
  const page = `${HERE}vite`;
  await mkdir(page, { recursive: true });
  t.after(() => rm(page, { recursive: true, force: true }));
  await writeFile(`${page}/index.html`, PAGE("../by-url.js"));
  await build({ root: page, logLevel: "error", build: { outDir: out, emptyOutDir: true } });
  assert.equal(await browse(t, out), RIGHT);

  await writeFile(`${page}/index.html`, PAGE("/@fs" + `${HERE}by-url.js`));
  const { seen, hear } = ear();
  const listens = { name: "ear", configureServer: (server) => void server.middlewares.use("/seen", hear) };
  const server = await develop({ root: page, logLevel: "error", plugins: [listens], server: { port: 0, host: "127.0.0.1", fs: { allow: [HERE] } } });
  await server.listen();
  t.after(() => server.close());
  assert.equal(await visit(t, server.resolvedUrls.local[0], seen), RIGHT);
});
