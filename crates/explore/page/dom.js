// Elements of the page, found and made.

export const $ = (id) => document.getElementById(id);

const filled = (made, attributes, ...children) => {
  for (const [key, v] of Object.entries(attributes)) made.setAttribute(key, v);
  made.append(...children);
  return made;
};

export const element = (name, attributes = {}, ...children) => filled(document.createElement(name), attributes, ...children);
export const svg = (name, attributes, ...children) => filled(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, ...children);

// |μ| is one word: no line ends within it.
export const unbroken = (text) => text.replaceAll("|μ|", [..."|μ|"].join("\u2060"));
