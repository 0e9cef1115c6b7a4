// Serves the package to browsers on this machine: `npm run page`, or `node page/serve.js [PORT]`.

import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname } from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".wasm": "application/wasm" };
const FOLDERS = ["/page/", "/src/", "/wasm/"];

/** A server of the three folders. `before` may answer a request in its place, and says so. */
export function serve(port, before = async () => false) {
  const server = createServer(async (request, response) => {
    const { pathname } = new URL(request.url, "http://localhost");
    if (await before(pathname, request, response)) {
      return;
    }
    if (pathname === "/") {
      response.writeHead(302, { location: "/page/index.html" }).end();
      return;
    }
    try {
      if (!FOLDERS.some((folder) => pathname.startsWith(folder))) {
        throw new Error("not of the package");
      }
      const bytes = await readFile(fileURLToPath(new URL(`..${pathname}`, import.meta.url)));
      response.writeHead(200, { "content-type": TYPES[extname(pathname)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      response.writeHead(404).end("not found");
    }
  });
  return new Promise((resolve) => server.listen(port, "127.0.0.1", () => resolve(server)));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const server = await serve(Number(process.argv[2] ?? 8080));
  console.log(`http://127.0.0.1:${server.address().port}/`);
}
