// Keeps of a student's work: for each unit the text, with its history.

const place = (stem) => `raykit:unit:${stem}`;

// Returns whether it is kept: a browser may have no room, or keep nothing at all.
export function keep(stem, value) {
  try {
    localStorage.setItem(place(stem), JSON.stringify(value));
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

export function forget(stem) { localStorage.removeItem(place(stem)); }
