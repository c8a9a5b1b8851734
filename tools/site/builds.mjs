// What a text was built into, kept in the browser for the next visit: that shows its verdict and its picture before clang
// is loaded. It goes with the version of the site that the service worker keeps.

// A page without the right to keep anything, such as one that no https protects, has no caches.
async function cache_of(site) {
  try {
    const {version} = await (await fetch(new URL("version.json", site))).json();
    return await caches.open(version);
  } catch {
    return null;
  }
}

const SAID = "said", MODULES = ["suite", "driver"];

export class Builds {
  #cache;
  #place;

  constructor(site, stem) {
    this.#cache = cache_of(site);
    this.#place = new URL(`built/${stem}`, site).href;
  }

  // Returns what was kept of these texts, {text, others}: what keep() got; or null, also for a record that is damaged.
  async kept(texts) {
    try {
      const cache = await this.#cache, answer = await cache.match(this.#place), form = await answer.formData();
      const {of, ...build} = JSON.parse(form.get(SAID));
      if (of !== JSON.stringify(texts)) return null;
      for (const name of MODULES) build[name] = form.has(name) ? new Uint8Array(await form.get(name).arrayBuffer()) : null;
      return build;
    } catch {
      return null; // no cache, no record, or no readable one: the text is built anew
    }
  }

  // build: suite and driver, modules as bytes, or null, and what JSON can hold.
  async keep(texts, {suite, driver, ...build}) {
    const form = new FormData(), modules = {suite, driver};
    form.set(SAID, JSON.stringify({of: JSON.stringify(texts), ...build}));
    for (const name of MODULES) if (modules[name]) form.set(name, new Blob([modules[name]]));
    const cache = await this.#cache;
    await cache?.put(this.#place, new Response(form)).catch(() => {}); // no room: the next visit builds it anew
  }
}
