// The menu of fields shown over the scene, and a legend of their colors.

import { $, h, number } from "./dom.js";
import { fieldRamp, gradient } from "./colours.js";

const FOOD = "food of ";

/**
 * Offers the fields of a world; returns the function that receives maps from the server.
 * @param {import("./stage.js").Stage} stage
 * @param {(name: string | null) => void} ask requests a field from the server
 */
export function fields(stage, ask) {
  const { hello } = stage;
  const foods = Object.entries(hello.foods ?? {}).filter(([, eaten]) => eaten.length).map(([name]) => FOOD + name);
  const names = [...(hello.fields ?? []), ...foods];
  const choice = /** @type {HTMLSelectElement} */ ($("field"));
  const words = (/** @type {string} */ name) => name.replaceAll("_", " ");
  choice.replaceChildren(h("option", { value: "", text: "none" }), ...names.map((name) => h("option", { value: name, text: words(name) })));
  $("fieldLabel").hidden = !names.length;
  let shade = () => {}; // draws the caption in the colors of another theme
  const caption = (/** @type {string} */ low, /** @type {string} */ high, /** @type {string} */ unit) => {
    shade = () => caption(low, high, unit);
    $("fieldRamp").hidden = false;
    $("fieldRamp").replaceChildren(words(choice.value), h("i", { style: `background:${gradient(fieldRamp(stage.dark))}` }), h("div", {}, h("span", { text: low }), h("em", { text: unit }), h("span", { text: high })));
  };
  const choose = () => {
    const name = choice.value;
    const eaten = name.startsWith(FOOD) && !hello.fields?.includes(name) ? (hello.foods?.[name.slice(FOOD.length)] ?? []) : [];
    stage.field.choose(name, eaten);
    stage.over.levels = [];
    $("fieldRamp").hidden = true;
    shade = () => {};
    ask(eaten.length || !name ? null : name);
    if (eaten.length) caption("none", "most", eaten.join(", "));
  };
  choice.onchange = choose;
  return {
    choose: (/** @type {string} */ name) => {
      if (!names.includes(name)) return;
      choice.value = name;
      choose();
    },
    shade: () => shade(),
    again: () => choice.value && choose(),
    take: (/** @type {import("./protocol.js").FieldMessage} */ message) => {
      if (!stage.field.take(message)) return;
      stage.over.levels = stage.field.levels();
      caption(number(message.low), number(message.high), message.unit);
    },
  };
}
