// A page in which a unit is written and checked: workbench.html?STEM. On every pause in typing the text is compiled and
// its claims run (check_worker.mjs); what they say stands beside it. Nothing is sent anywhere.

const PAUSE = 300; // milliseconds without a key after which a text is checked

const stem = location.search.slice(1).match(/^[a-z_]+/)?.[0] || "normals";
const shown = (id) => document.getElementById(id);
const worker = new Worker(new URL("check_worker.mjs", import.meta.url), {type: "module"});
let id = 0, timer = null, typed = 0, claims = [];

// Names of claims are sentences in C's spelling.
const sentence = (name) => name.replaceAll("_", " ");

function begin() {
  shown("state").textContent = "Checking";
  worker.postMessage({id: ++id, text: shown("text").value});
}

function show_claims(list) {
  claims = list;
  shown("claims").replaceChildren(...list.map(({name}) => {
    const item = document.createElement("li");
    item.id = name;
    item.textContent = sentence(name);
    return item;
  }));
}

function show_verdict({claim, verdict, message, place}) {
  const item = shown(claim), said = document.createElement("small");
  item.dataset.verdict = verdict;
  said.textContent = verdict === "passed" ? "holds" : `${message}${place && ` (${place})`}`;
  item.replaceChildren(sentence(claim), said);
}

function show_end(seconds) {
  const passed = shown("claims").querySelectorAll("[data-verdict=passed]").length;
  const after = ((performance.now() - typed) / 1000).toFixed(2);
  shown("state").textContent = `${passed} of ${claims.length} claims hold`;
  shown("seconds").textContent = `${after} s after the last key: ` +
    Object.entries(seconds).filter(([, value]) => value !== undefined).map(([part, value]) => `${part} ${value.toFixed(2)} s`).join(", ");
}

function told({loaded, claims: list, said, built, verdict, ends, failed}) {
  if (failed) shown("state").textContent = `It does not go on: ${failed}`;
  if (loaded !== undefined) shown("loaded").value = loaded;
  if (list) {
    show_claims(list);
    shown("loaded").hidden = true;
    if (shown("text").value) begin();
    else shown("state").textContent = "Ready";
  }
  if (said !== undefined) {
    shown("said").textContent = said;
    for (const item of shown("claims").children) delete item.dataset.verdict;
    if (!built) shown("state").textContent = "The compiler finds an error";
  }
  if (verdict) show_verdict(verdict);
  if (ends && ends.run !== undefined) show_end(ends);
}

worker.onmessage = ({data}) => {
  if (data.id === undefined || data.id === id) told(data);
};
shown("stem").textContent = stem;
shown("text").addEventListener("input", () => {
  clearTimeout(timer);
  typed = performance.now();
  timer = setTimeout(begin, PAUSE);
});
worker.postMessage({site: new URL("./", location.href).href, stem});
fetch(`starters/${stem}.c`).then((answer) => answer.text()).then((text) => {
  if (!shown("text").value) shown("text").value = text;
  if (claims.length) begin();
});
