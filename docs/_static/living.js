// A click on the picture of a recorded run starts the run in the picture's place.
document.addEventListener("click", event => {
  const link = event.target.closest?.("a.living");
  if (!link || event.button || event.ctrlKey || event.metaKey || event.shiftKey) return; // a new tab or window
  event.preventDefault();
  const frame = document.createElement("iframe");
  frame.src = link.href;
  frame.title = link.querySelector("img").alt;
  frame.allowFullscreen = true;
  const box = document.createElement("div");
  box.className = "replay";
  box.append(frame);
  link.replaceWith(box);
  frame.focus();
});
