// Keeps the page in the browser: after one visit it needs no network. The build script of magician-studio fills in the two lines below.
const BUILD = "";
const FILES = [];

// Pages of other folders of the same server have theirs.
const OURS = `magician ${registration.scope} `;
const CACHE = OURS + BUILD;
const named = (file) => new URL(file === "index.html" ? "./" : file, registration.scope).href;
const KNOWN = new Set(FILES.map(named));

addEventListener("install", (event) => {
  // Whole or not at all, and past the browser's own cache, which may have a file of another build.
  const all = [...KNOWN].map((url) => new Request(url, { cache: "reload" }));
  event.waitUntil(caches.open(CACHE).then((cache) => cache.addAll(all)));
});

addEventListener("activate", (event) => {
  const tidied = async () => {
    for (const name of await caches.keys()) {
      if (name.startsWith(OURS) && name !== CACHE) await caches.delete(name);
    }
    await clients.claim();
  };
  event.waitUntil(tidied());
});

// A newer build waits until the person takes it.
addEventListener("message", (event) => {
  if (event.data === "take") skipWaiting();
});

addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.method !== "GET") return;
  const url = new URL(request.url);
  url.search = "";
  url.hash = "";
  if (url.href === new URL("index.html", registration.scope).href) url.href = registration.scope;
  if (!KNOWN.has(url.href)) return;
  const answer = async () => (await (await caches.open(CACHE)).match(url.href)) ?? fetch(request);
  event.respondWith(answer());
});
