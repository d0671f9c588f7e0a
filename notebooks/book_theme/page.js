// Typeset the formulas, and let the keyboard reach what scrolls sideways.
"use strict";
renderMathInElement(document.body, {
  delimiters: [
    { left: "$$", right: "$$", display: true },
    { left: "$", right: "$", display: false },
  ],
  throwOnError: false,
});

function reach() {
  for (const block of document.querySelectorAll("pre, .scroll, .katex-display")) {
    if (block.scrollWidth > block.clientWidth) block.tabIndex = 0;
    else block.removeAttribute("tabindex");
  }
}
document.addEventListener("toggle", reach, true);
window.addEventListener("resize", reach);
document.fonts.ready.then(reach);
document.fonts.addEventListener("loadingdone", reach);
