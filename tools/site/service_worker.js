// Lets the site work without a network after the first visit. `make site` puts in the version, which changes with any
// file, and the files that the workbench needs; others, such as chapters, are kept when they are first seen.
const VERSION = "{version}", NEEDED = "{needed}";

addEventListener("install", (event) => {
  // Servers let browsers keep a file for some minutes; "no-cache" asks whether it has changed meanwhile.
  const asked = NEEDED.map((name) => new Request(name, {cache: "no-cache"}));
  event.waitUntil(caches.open(VERSION).then((cache) => cache.addAll(asked)).then(() => skipWaiting()));
});

addEventListener("activate", (event) => {
  const old = async () => Promise.all((await caches.keys()).filter((name) => name !== VERSION).map((name) => caches.delete(name)));
  event.waitUntil(old().then(() => clients.claim()));
});

async function answer(request) {
  const {origin, pathname} = new URL(request.url), file = origin + pathname.replace(/\/$/, "/index.html"); // without ?work and the like
  const cache = await caches.open(VERSION), known = await cache.match(file);
  if (known) return known;
  const fresh = await fetch(request);
  if (fresh.ok) await cache.put(file, fresh.clone());
  return fresh;
}

addEventListener("fetch", (event) => {
  if (event.request.method === "GET" && new URL(event.request.url).origin === location.origin) event.respondWith(answer(event.request));
});
