// Elements of the page. Names come from files of strangers, so all text is set by textContent.

export function byId(id) {
  return document.getElementById(id);
}

// element("button", {type: "button", onclick: f}, "text", child, …); a member with a dash is an attribute.
export function element(tag, members = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(members)) {
    if (name.includes("-") || name === "role" || name === "list" || name === "for") made.setAttribute(name, value);
    else made[name] = value;
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

export function say(text) {
  byId("hint").textContent = text;
}

// A refusal or a fault, which stays until the next one or the next success; "" clears it.
export function warn(text) {
  const line = byId("alert");
  line.textContent = text;
  line.hidden = !text;
}

// A question with answers [{text, value, main}]; gives the value, or null after Esc. input: of a number or a text.
export function ask(text, answers, input = null) {
  const dialog = byId("dialog");
  return new Promise((resolve) => {
    const buttons = answers.map(({ text: name, value, main }) =>
      element("button", { type: main ? "submit" : "button", className: main ? "main" : "", value: String(value),
        onclick: main ? null : () => finish(value) }, name));
    const main = answers.find((answer) => answer.main);
    const form = element("form", { method: "dialog", onsubmit: (event) => {
      event.preventDefault();
      finish(input ? input.value : main.value);
    } }, element("p", { id: "dialog-text" }, text), input, element("div", { className: "answers" }, ...buttons));
    function finish(value) {
      dialog.oncancel = null;
      dialog.close();
      resolve(value);
    }
    dialog.replaceChildren(form);
    dialog.oncancel = (event) => {
      event.preventDefault();
      finish(null);
    };
    dialog.showModal();
    (input ?? form.querySelector("button.main"))?.focus();
  });
}

// areas: of the state of a floor, how far its scale is to be trusted; not there for graphs, and floors without a folder.
export function formatArea(area, areas) {
  if (areas?.trust === "unknown") return "?";
  return areas?.trust === "rough" ? `≈ ${Number(area.toPrecision(2))} m²` : `${area.toFixed(1)} m²`;
}

export function formatShare(probability) {
  return `${Math.round(probability * 100)} %`;
}
