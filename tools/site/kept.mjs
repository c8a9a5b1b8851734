// Keeps of a student's work: for each unit the text, with its history and its last verdict.

const LAST = "raykit:last";
const place = (stem) => `raykit:unit:${stem}`;

// Returns whether it is kept: a browser may have no room, or keep nothing at all.
export function keep(stem, value) {
  try {
    localStorage.setItem(place(stem), JSON.stringify(value));
    localStorage.setItem(LAST, stem);
    return true;
  } catch {
    return false;
  }
}

// Returns what was kept last, or null.
export function kept(stem) {
  try {
    return JSON.parse(localStorage.getItem(place(stem)));
  } catch {
    return null;
  }
}

// Returns the unit that was kept last, or null.
export function last_kept() {
  try {
    return localStorage.getItem(LAST);
  } catch {
    return null;
  }
}

export function forget(stem) { localStorage.removeItem(place(stem)); }

// Calls when another tab has kept something of a unit.
export function when_kept(stem, call) {
  addEventListener("storage", ({key}) => { if (key === place(stem)) call(); });
}
