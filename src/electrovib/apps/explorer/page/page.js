// Run once in the page of a visitor: the page itself follows the buttons 'back' and 'forward' of the browser.
window.addEventListener('popstate', () => emitEvent('explorer_back', window.location.search));
// A link of the page is followed without loading it again, unless it is opened elsewhere.
document.addEventListener('click', event => {
  const link = event.target.closest('a.ev-link');
  if (!link || event.button || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
  event.preventDefault();
  emitEvent('explorer_link', link.search);
});
// The strip of a story stays below the bar.
const bar = document.querySelector('.q-header');
new ResizeObserver(() => document.body.style.setProperty('--ev-top', `${bar.offsetHeight}px`)).observe(bar);
