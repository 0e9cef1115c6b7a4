// The page in a browser: it draws, its pairs are those of brute force, its slider works, and nothing is said on the console.
//
// Needs Debian's `chromium`. Without it the tests say that they are skipped; with `TRISAP_NO_SKIP` set, they fail.
// The picture in the README is made by `TRISAP_SCREENSHOT=page.png node --test test/page.test.js`.

import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { mkdtemp, readFile, rm, stat } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { serve } from "../page/serve.js";

const BROWSER = "chromium";
const PATIENCE = 120_000;
const installed = spawnSync(BROWSER, ["--version"]).status === 0;
const skip = !installed && !process.env.TRISAP_NO_SKIP ? `skipped: ${BROWSER} is not installed` : false;

/** Runs in the page: looks at what is there, moves the slider, looks again. */
async function look() {
  const { scene } = await import("/page/page.js");
  const { bruteForce, texts } = await import("/test/brute.js");
  const next = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const until = async (ready) => {
    while (!ready()) {
      await next();
    }
  };
  const colours = () => {
    const canvas = document.querySelector("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const seen = {};
    for (let i = 0; i < data.length; i += 4) {
      const colour = `${data[i]},${data[i + 1]},${data[i + 2]},${data[i + 3]}`;
      seen[colour] = (seen[colour] ?? 0) + 1;
    }
    return Object.fromEntries(Object.entries(seen).sort((a, b) => b[1] - a[1]).slice(0, 4));
  };
  const say = (name) => document.querySelector(`#${name}`).textContent;
  const looks = [];
  for (const count of [3000, 700]) {
    const slider = document.querySelector("#number");
    if (slider.value !== String(count)) {
      slider.value = count;
      slider.dispatchEvent(new Event("input"));
    }
    await until(() => scene.count === count);
    for (let step = 0; step < 3; step++) {
      const frames = scene.frames;
      await until(() => scene.frames > frames + 2);
      // Between two frames: the boxes are those of the last step.
      const { world } = scene;
      const expected = bruteForce(world.boxes);
      const pairs = texts(world.pairs);
      looks.push({
        count, shown: Number(say("boxes")), expected: expected.length, pairs: Number(say("pairs")),
        same: JSON.stringify(pairs) === JSON.stringify(expected), found: Number(say("found")), lost: Number(say("lost")),
        time: Number(say("time")), variant: say("variant"), colours: colours(),
        width: innerWidth, needed: document.documentElement.scrollWidth,
      });
    }
  }
  return looks;
}

/** Everything that goes wrong in the page is told. */
const WATCH = `<script>
globalThis.complaints = [];
for (const name of ["error", "warn"]) {
  const say = console[name];
  console[name] = (...words) => { complaints.push(words.join(" ")); say.apply(console, words); };
}
addEventListener("error", (event) => complaints.push(String(event.message)));
addEventListener("unhandledrejection", (event) => complaints.push(String(event.reason)));
</script>`;
const LOOK = `<script type="module">
const seen = await (${look})().catch((error) => complaints.push(String(error.stack)));
await fetch("/seen", { method: "POST", body: JSON.stringify({ seen, complaints }) });
</script>`;

/** A browser with a page of this server, and what the page has sent. */
async function visit(query, flags) {
  const page = await readFile(new URL("../page/index.html", import.meta.url), "utf8");
  const brute = await readFile(new URL("brute.js", import.meta.url));
  const folder = await mkdtemp(join(tmpdir(), "trisap-page-"));
  let tell;
  const told = new Promise((resolve) => (tell = resolve));
  const server = await serve(0, async (path, request, response) => {
    if (path === "/page/look.html") {
      const watched = page.replace("<head>", `<head>${WATCH}`).replace("</body>", `${LOOK}</body>`);
      response.writeHead(200, { "content-type": "text/html; charset=utf-8" }).end(watched);
    } else if (path === "/test/brute.js") {
      response.writeHead(200, { "content-type": "text/javascript" }).end(brute);
    } else if (path === "/seen") {
      let body = "";
      for await (const chunk of request) {
        body += chunk;
      }
      response.end();
      tell(JSON.parse(body));
    } else {
      return false;
    }
    return true;
  });
  const address = `http://127.0.0.1:${server.address().port}/page`;
  const child = browser(folder, [...flags, "--enable-logging=stderr", `${address}/look.html${query}`]);
  let log = "";
  child.stderr.on("data", (text) => (log += text));
  const gone = new Promise((resolve) => child.on("exit", resolve));
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`the page has not told what it sees:\n${log}`)), PATIENCE);
  });
  try {
    return { ...(await Promise.race([told, late])), log };
  } finally {
    clearTimeout(timer);
    child.kill();
    await gone;
    server.closeAllConnections();
    server.close();
    await rm(folder, { recursive: true, force: true, maxRetries: 5 });
  }
}

function browser(folder, more) {
  // Its sandbox does not work inside those of build machines.
  const flags = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run", "--mute-audio"];
  return spawn(BROWSER, [...flags, `--user-data-dir=${folder}`, ...more], { stdio: ["ignore", "ignore", "pipe"] });
}

const cases = [
  ["with vectors", "", [], "simd128"],
  ["without vectors", "", ["--js-flags=--no-enable-sse4-1"], "scalar"],
  ["without vectors by choice, on a phone", "?scalar", ["--window-size=390,800"], "scalar"],
];
for (const [name, query, flags, variant] of cases) {
  test(`the page ${name}`, { skip }, async () => {
    const { seen, complaints, log } = await visit(query, flags);
    assert.deepEqual(complaints, []);
    assert.doesNotMatch(log, /CONSOLE.*(error|warn)/i);
    assert.equal(seen.length, 6);
    for (const look of seen) {
      assert.ok(look.same, `${look.count} boxes: the pairs are not those of brute force`);
      assert.equal(look.pairs, look.expected);
      assert.equal(look.shown, look.count);
      assert.ok(look.expected > look.count / 20, `${look.expected} pairs of ${look.count} boxes`);
      assert.ok(look.time >= 0 && look.found >= 0 && look.lost >= 0);
      assert.equal(look.variant, variant);
      assert.ok(look.needed <= look.width, `the page is ${look.needed} wide on ${look.width}`);
      // Boxes, lit boxes and overlaps are drawn.
      for (const colour of ["61,111,168,255", "255,159,63,255", "255,243,214,255"]) {
        assert.ok(look.colours[colour] > 500, `${colour}: ${JSON.stringify(look.colours)}`);
      }
    }
  });
}

test("the picture of the page", { skip: skip || (!process.env.TRISAP_SCREENSHOT && "not asked for") }, async () => {
  const target = fileURLToPath(new URL(`../${process.env.TRISAP_SCREENSHOT}`, import.meta.url));
  const folder = await mkdtemp(join(tmpdir(), "trisap-page-"));
  const page = await readFile(new URL("../page/index.html", import.meta.url), "utf8");
  // The browser takes the picture when everything has come: the last thing comes late.
  const server = await serve(0, async (path, _, response) => {
    if (path === "/page/late.html") {
      const late = page.replace("</body>", '<img src="late.gif" alt="" style="display: none"></body>');
      response.writeHead(200, { "content-type": "text/html; charset=utf-8" }).end(late);
    } else if (path === "/page/late.gif") {
      setTimeout(() => response.writeHead(404).end(), 5000);
    }
    return path.startsWith("/page/late.");
  });
  const address = `http://127.0.0.1:${server.address().port}/page/late.html`;
  const child = browser(folder, ["--window-size=680,560", `--screenshot=${target}`, address]);
  await new Promise((resolve) => child.on("exit", resolve));
  server.closeAllConnections();
  server.close();
  await rm(folder, { recursive: true, force: true, maxRetries: 5 });
  const { size } = await stat(target);
  assert.ok(size > 50_000 && size < 200_000, `${size} bytes`);
});
