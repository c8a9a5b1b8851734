// In a chapter that was opened from the workbench, as ?work, and in those read after it, the kit's units are folded, so
// that nobody sees a solution by accident, and so are figures that play them.
"use strict";
(() => {
  let isWork = new URLSearchParams(location.search).has("work");
  try {
    if (isWork) sessionStorage.setItem("raykit-work", "yes");
    isWork = sessionStorage.getItem("raykit-work") === "yes";
  } catch { /* a browser that keeps nothing: this page alone */ }
  if (!isWork) return;
  const isUnit = (name) => /^src\/features\/\w+\.c$/.test(name);
  const fold = (part, title) => {
    const details = document.createElement("details"), summary = document.createElement("summary");
    summary.textContent = title;
    part.replaceWith(details);
    details.append(summary, part);
  };
  for (const from of document.querySelectorAll(".listing .from code"))
    if (isUnit(from.textContent)) fold(from.closest(".listing"), "The kit's code: a solution");
  for (const replay of document.querySelectorAll(".replay"))
    if (isUnit(replay.dataset.file)) fold(replay, "The kit's code, line by line: a solution");
})();
