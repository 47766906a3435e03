// In a page saved as a file: decompresses the run and the modules, which are in the page as base64, and starts main.js.
// This script is not a module, because browsers load no modules from files; blobs have no relative addresses, so imports are replaced.

"use strict";

(async () => {
  /** @param {Element} element */
  const unpacked = (element) => {
    const text = atob((element.textContent ?? "").trim()), bytes = new Uint8Array(text.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
    element.remove();
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  };
  try {
    window.run = Promise.all([...document.querySelectorAll("[data-part]")].map(unpacked));
    const code = await unpacked(/** @type {Element} */ (document.getElementById("code")));
    /** @type {Record<string, string>} */
    const urls = {};
    for (const [name, text] of JSON.parse(new TextDecoder().decode(code))) { // a module follows the modules that it imports
      const linked = text.replace(/\bfrom "\.\/(\w+\.js)"/g, (/** @type {string} */ all, /** @type {string} */ file) => (urls[file] ? `from "${urls[file]}"` : all));
      urls[name] = URL.createObjectURL(new Blob([linked], { type: "text/javascript" }));
    }
    await import(urls["main.js"]);
  } catch (error) {
    const notice = /** @type {HTMLElement} */ (document.getElementById("notice"));
    notice.textContent = `This page needs a browser of 2023 or later (${error}).`;
    notice.hidden = false;
  }
})();
