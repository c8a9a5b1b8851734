// Elements of a page, in few words.

// made("p", {className: "note"}, "text", element)
export function made(tag, more = {}, ...children) {
  const element = Object.assign(document.createElement(tag), more);
  element.append(...children);
  return element;
}

// Texts of the site's own files, made by site_tasks.py.
export const html = (tag, text, more) => made(tag, {...more, innerHTML: text});

// Texts as handouts have them, with code between backticks.
export const plain = (tag, text, more) => made(tag, more, ...text.split("`").map((part, i) => i % 2 ? made("code", {textContent: part}) : part));

export const shown = (id) => document.getElementById(id);

// Asks in a dialog: resolves to the value of the button, or to "" if it is closed by Escape. buttons: {value: words}; the
// one whose value is "" is chosen by Enter.
export function asked(title, content, buttons) {
  const dialog = made("dialog", {}, made("form", {method: "dialog"}, made("h2", {id: "asked", textContent: title}), ...content,
    made("p", {className: "buttons"}, ...Object.entries(buttons).map(([value, textContent]) => made("button", {value, textContent, autofocus: !value})))));
  dialog.setAttribute("aria-labelledby", "asked");
  document.body.append(dialog);
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.onclose = () => {
      dialog.remove();
      resolve(dialog.returnValue);
    };
  });
}
