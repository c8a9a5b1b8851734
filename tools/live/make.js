// An element with its properties and children. Used by live.js and by the figures that go step by step.
const make = (tag, properties, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
