// Helps to read: contents that follow the reader, search, colours, links to headings and figures, copies of listings.
// The page is complete without.
"use strict";
(() => {
  const make = (name, attributes, ...children) => {
    const element = document.createElement(name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    element.append(...children);
    return element;
  };

  // --- colours: the system's, unless the reader chooses ---------------------------------------

  const root = document.documentElement;
  const themes = ["auto", "light", "dark"].map((theme) => {
    const button = make("button", { type: "button" }, theme);
    button.addEventListener("click", () => {
      if (theme === "auto") delete root.dataset.theme;
      else root.dataset.theme = theme;
      try {
        if (theme === "auto") localStorage.removeItem("raykit-theme");
        else localStorage.setItem("raykit-theme", theme);
      } catch { /* it holds for this page alone */ }
      press();
    });
    return button;
  });
  const press = () => {
    for (const button of themes) button.setAttribute("aria-pressed", String(button.textContent === (root.dataset.theme || "auto")));
  };
  press();
  document.querySelector("header").prepend(make("div", { class: "theme", role: "group", "aria-label": "Colours" }, ...themes));

  // --- contents ------------------------------------------------------------------------------

  const contents = document.querySelector("nav.contents");
  const wide = matchMedia("(min-width: 76rem)");
  const fold = contents.querySelector("details");
  const unfoldIfWide = () => { fold.open = wide.matches; };
  unfoldIfWide();
  wide.addEventListener("change", unfoldIfWide);
  addEventListener("beforeprint", () => { fold.open = true; });
  addEventListener("afterprint", unfoldIfWide);
  contents.classList.add("follows");

  const links = new Map();
  for (const link of contents.querySelectorAll("li a")) {
    const [page, name] = link.getAttribute("href").split("#");
    if (!page) links.set(name, link);
  }
  const headings = [...document.querySelectorAll("main h1[id], main h2[id]")].filter((heading) => links.has(heading.id));

  const show = (link) => {
    for (const old of contents.querySelectorAll("[aria-current]")) old.removeAttribute("aria-current");
    link.setAttribute("aria-current", "true");
    const item = link.closest("nav > details > ul > li");
    for (const other of contents.querySelectorAll("li.current")) other.classList.toggle("current", other === item);
    item.classList.add("current");
    if (!wide.matches) return;
    const box = contents.getBoundingClientRect();
    const place = link.getBoundingClientRect();
    if (place.top < box.top + 80) contents.scrollTop += place.top - box.top - 80;
    if (place.bottom > box.bottom - 40) contents.scrollTop += place.bottom - box.bottom + 40;
  };
  const follow = () => {
    let current = headings[0];
    for (const heading of headings) {
      if (heading.getBoundingClientRect().top > innerHeight / 3) break;
      current = heading;
    }
    if (current) show(links.get(current.id));
  };
  // All that is above a third of the window, so that jumps over several headings count as well.
  const observer = new IntersectionObserver(follow, { rootMargin: "10000000px 0px -66% 0px" });
  headings.forEach((heading) => observer.observe(heading));

  // --- search: by MiniSearch, where the page has its script (make_search.js) ------------------

  const is_paged = Boolean(document.querySelector('link[href="style.css"]'));
  const kept = document.getElementById("search-script"), beside = document.querySelector('link[href="search.js"]');
  const field = make("input", { type: "search", placeholder: "Search", autocomplete: "off",
    "aria-label": "Search headings, functions, tests, terms and the text", "aria-controls": "found" });
  const found = make("ul", { id: "found", hidden: "" });
  const said = make("p", { class: "said", role: "status" });
  const most = { names: 8, texts: 12 };

  // The part of the text that has most of these words, which are marked.
  const around = 60;
  const excerpt = (text, words) => {
    const escaped = words.map((word) => word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
    const hits = [...text.matchAll(new RegExp(`(?<![\\p{L}\\p{N}])(${escaped.join("|")})(?![\\p{L}\\p{N}])`, "giu"))];
    const near = (hit) => new Set(hits.filter(({ index }) => index >= hit.index && index < hit.index + around).map(([word]) => word.toLowerCase())).size;
    const best = hits.reduce((one, hit) => near(hit) > near(one) ? hit : one, hits[0] || { index: 0 });
    const from = best.index > around ? text.indexOf(" ", best.index - around) + 1 : 0, to = best.index + 2 * around;
    const end = to < text.length ? text.lastIndexOf(" ", to) : text.length;
    const parts = from ? ["… "] : [];
    let at = from;
    for (const { 0: word, index } of hits) {
      if (index < at || index + word.length > end) continue;
      parts.push(text.slice(at, index), make("mark", {}, word));
      at = index + word.length;
    }
    return make("span", { class: "excerpt" }, ...parts, text.slice(at, end), end < text.length ? " …" : "");
  };
  const result = ({ at, name, title, kind, text, terms }) => {
    const [page, , section, chapter] = raykitSections[at], told = kind || (chapter && chapter !== section && `in ${chapter}`);
    const link = make("a", { href: `${document.getElementById(name) ? "" : page}#${name}` }, title || section);
    return make("li", {}, link, told ? make("small", {}, told) : "", text ? excerpt(text, terms) : "");
  };

  const search = () => {
    if (!window.raykitFind) return;
    const wanted = field.value.trim(), hits = wanted.length > 1 ? raykitFind(wanted) : [];
    const shown = [...hits.filter(({ kind }) => kind).slice(0, most.names), ...hits.filter(({ kind }) => !kind).slice(0, most.texts)];
    found.replaceChildren(...shown.map(result));
    found.hidden = !hits.length;
    const count = `${hits.length > shown.length ? `${shown.length} of ` : ""}${hits.length} ${hits.length === 1 ? "place" : "places"}`;
    said.textContent = wanted.length < 2 ? "" : hits.length ? count : "nothing found";
  };
  // The script is loaded for who searches; a single file has it as text.
  field.addEventListener("focus", () => {
    if (window.raykitFind) return;
    const script = make("script", beside ? { src: beside.href } : {}, kept ? kept.textContent : "");
    script.addEventListener("load", search);
    document.head.append(script);
  }, { once: true });
  field.addEventListener("input", search);
  const box = make("div", { class: "search", role: "search" }, field, found, said);
  box.addEventListener("keydown", (event) => {
    const stops = [field, ...found.querySelectorAll("a")], at = stops.indexOf(document.activeElement);
    const to = stops[at + { ArrowDown: 1, ArrowUp: -1 }[event.key]];
    if (to) to.focus();
    if (to) event.preventDefault();
    if (event.key === "Enter" && at === 0 && stops[1]) stops[1].click();
    if (event.key !== "Escape") return;
    field.value = "";
    field.focus();
    search();
  });
  if (kept || beside) contents.prepend(box);

  // --- the other pages -----------------------------------------------------------------------

  // places.js has the page of each name.
  const with_places = (use) => {
    const script = make("script", { src: "places.js" });
    script.addEventListener("load", () => use(raykitPlaces));
    document.head.append(script);
  };

  // Links may be from before a section had a page of its own.
  const target = () => document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const look_elsewhere = () => {
    if (location.hash.length < 2 || target() || !is_paged) return;
    with_places((places) => {
      const page = places[decodeURIComponent(location.hash.slice(1))];
      if (page) location.replace(page + location.search + location.hash);
    });
  };

  // The site's worker keeps what was seen. Who has begun to read can go on, and search, without a network.
  const keep_all = async (places) => {
    for (const page of new Set([...Object.values(places), "search.js"])) {
      if (!await caches.match(page, { ignoreSearch: true })) await fetch(page, { priority: "low" });
    }
  };
  if (is_paged && navigator.serviceWorker?.controller && !navigator.connection?.saveData)
    addEventListener("load", () => setTimeout(() => with_places((places) => keep_all(places).catch(() => {})), 1000));

  // A test that is linked to unfolds, with the list around it.
  const unfold = () => {
    const linked = target();
    for (let fold = linked && linked.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
    if (linked && linked.closest("details")) linked.scrollIntoView();
    look_elsewhere();
  };
  addEventListener("hashchange", unfold);
  unfold();

  // --- headings, figures and listings --------------------------------------------------------

  for (const heading of document.querySelectorAll("main :is(h1, h2, h3)[id]")) {
    const title = heading.textContent.trim();
    heading.append(make("a", { class: "permalink", href: "#" + heading.id, "aria-label": "Link to " + title }, "#"));
  }

  const kinds = { FIGURE: "", DIV: "the listing ", SPAN: "Equation " }; // a figure's number says what it is
  for (const block of document.querySelectorAll("main :is(figure, .listing, .equation)[id]")) {
    const name = block.querySelector(".number, .from") || block.querySelector(".caption");
    const title = kinds[block.tagName] + (name ? name.textContent.trim() : "");
    (block.querySelector(".caption") || block).append(make("a", { class: "permalink", href: "#" + block.id, "aria-label": "Link to " + title }, "#"));
  }

  const copy = async (button, code) => {
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "copied";
    } catch {
      getSelection().selectAllChildren(code);
      button.textContent = "selected";
    }
    setTimeout(() => { button.textContent = "copy"; }, 1500);
  };
  for (const code of document.querySelectorAll("main pre > code")) {
    const button = make("button", { type: "button", class: "copy", "aria-label": "Copy this code" }, "copy");
    button.addEventListener("click", () => copy(button, code));
    const block = code.parentElement;
    const holder = make("div", { class: "copyable" });
    block.replaceWith(holder);
    holder.append(block, button);
  }
})();
