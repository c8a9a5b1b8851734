// Helps to read: contents that follow the reader, search, colours, links to headings and figures, copies of listings.
// The page is complete without. `raykitIndex` has the names that can be searched for, [title, kind, anchor, page],
// `raykitText`, in text.js, the sections: [page, anchor, title, text].
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

  // --- search --------------------------------------------------------------------------------

  const field = make("input", { type: "search", placeholder: "Search", autocomplete: "off",
    "aria-label": "Search headings, functions, tests, terms and the text", "aria-controls": "found" });
  const found = make("ul", { id: "found", hidden: "" });
  const said = make("p", { class: "said", role: "status" });
  const most = 12;

  // Beginnings of titles first, then beginnings of words.
  const rank = (title, wanted) => {
    const at = title.toLowerCase().indexOf(wanted);
    return at <= 0 ? at : /[\s_]/.test(title[at - 1]) ? 1 : 2;
  };
  const names = (wanted) => raykitIndex.map((entry) => [rank(entry[0].replace(/^[\d.]+ /, ""), wanted), entry])
    .filter(([order]) => order >= 0).sort((a, b) => a[0] - b[0]).map(([, entry]) => entry);

  // Sections with all of the words, the whole phrase first, then those that have them most often.
  const count = (text, word) => text.split(word).length - 1;
  const texts = (wanted) => {
    const words = wanted.split(/\s+/), hits = [];
    for (const [page, name, title, text] of window.raykitText || []) {
      const lower = text.toLowerCase(), counts = words.map((word) => count(lower, word));
      if (Math.min(...counts)) hits.push([count(lower, wanted), Math.min(...counts), [title, text, name, page], lower]);
    }
    return hits.sort((a, b) => b[0] - a[0] || b[1] - a[1]).map(([whole, , row, lower]) => [...row, lower.indexOf(whole ? wanted : words[0]), whole ? wanted : words[0]]);
  };
  const excerpt = (text, at, word) => make("span", { class: "excerpt" }, 
    at > 50 ? "… " + text.slice(at - 50, at).replace(/^\S*\s/, "") : text.slice(0, at),
    make("mark", {}, text.substr(at, word.length)), text.substr(at + word.length, 60).replace(/\s\S*$/, " …"));
  const chapterOf = (page, title) => {
    const [, , chapter] = raykitText.find((row) => row[0] === page);
    return chapter === title ? "" : make("small", {}, "in " + chapter);
  };
  const link = (name, page, title) => make("a", { href: (document.getElementById(name) ? "" : page) + "#" + name }, title);

  const search = () => {
    const wanted = field.value.trim().toLowerCase();
    const named = wanted.length > 1 ? names(wanted) : [], written = wanted.length > 2 ? texts(wanted) : [];
    found.replaceChildren(...named.slice(0, most).map(([title, kind, name, page]) => make("li", {}, link(name, page, title), make("small", {}, kind))),
      ...written.slice(0, most).map(([title, text, name, page, at, word]) => make("li", {}, link(name, page, title), chapterOf(page, title), excerpt(text, at, word))));
    found.hidden = !found.firstChild;
    const told = (hits, what) => hits.length > most ? [`${most} of ${hits.length} ${what}`] : hits.length ? [`${hits.length} ${what}`] : [];
    said.textContent = wanted.length < 2 ? "" : [...told(named, "names"), ...told(written, "sections")].join(", ") || "nothing found";
  };
  // The text is loaded for who searches; a single file has it.
  field.addEventListener("focus", () => {
    if (window.raykitText) return;
    const script = make("script", { src: "text.js" });
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
  contents.prepend(box);

  // A test that is linked to unfolds, with the list around it.
  const unfold = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    for (let around = target && target.closest("details"); around; around = around.parentElement.closest("details")) around.open = true;
    if (target && target.closest("details")) target.scrollIntoView();
  };
  addEventListener("hashchange", unfold);
  unfold();

  // --- headings, figures and listings --------------------------------------------------------

  for (const heading of document.querySelectorAll("main :is(h1, h2, h3)[id]")) {
    const title = heading.textContent.trim();
    heading.append(make("a", { class: "permalink", href: "#" + heading.id, "aria-label": "Link to " + title }, "#"));
  }

  for (const figure of document.querySelectorAll("main figure[id]")) {
    const caption = figure.querySelector(".caption, figcaption");
    const number = caption && caption.querySelector(".number");
    if (caption) caption.append(make("a", { class: "permalink", href: "#" + figure.id, "aria-label": "Link to " + (number ? number.textContent.trim() : "this figure") }, "#"));
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
