// In a chapter that was opened from the workbench, as ?work, and in those read after it, the kit's units are folded, so
// that nobody sees a solution by accident.
"use strict";
(() => {
  let isWork = new URLSearchParams(location.search).has("work");
  try {
    if (isWork) sessionStorage.setItem("raykit-work", "yes");
    isWork = sessionStorage.getItem("raykit-work") === "yes";
  } catch { /* a browser that keeps nothing: this page alone */ }
  if (!isWork) return;
  for (const from of document.querySelectorAll(".listing .from code")) {
    if (!/^src\/features\/\w+\.c$/.test(from.textContent)) continue;
    const listing = from.closest(".listing"), details = document.createElement("details"), summary = document.createElement("summary");
    summary.textContent = "The kit's code: a solution";
    listing.replaceWith(details);
    details.append(summary, listing);
  }
})();
