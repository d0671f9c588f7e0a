// Show the sections that hold every word asked for, best first. The index is a script too, since
// a page that was opened from a folder may not read other files.
"use strict";
const asked = new URLSearchParams(location.search).get("query") ?? "";
const words = asked.toLowerCase().split(/\s+/).filter(Boolean);

const count = (text, word) => text.toLowerCase().split(word).length - 1;

function score(section) {
  const counts = words.map((word) => 10 * count(section.heading, word) + count(section.text, word));
  return counts.every(Boolean) ? counts.reduce((sum, one) => sum + one, 0) : 0;
}

function excerpt(text) {
  const near = text.toLowerCase().indexOf(words[0]) - 80;
  const start = near > 0 ? text.indexOf(" ", near) : 0;
  return (start ? "…" : "") + text.slice(start, text.lastIndexOf(" ", start + 220)).trim() + "…";
}

function entry(section) {
  const item = document.createElement("li");
  const link = item.appendChild(document.createElement("a"));
  link.href = section.address;
  link.textContent = section.heading === section.chapter ? section.chapter : `${section.chapter} › ${section.heading}`;
  item.appendChild(document.createElement("p")).textContent = excerpt(section.text);
  return item;
}

const found = sections.filter(score).sort((one, other) => score(other) - score(one));
document.getElementById("query").value = asked;
document.getElementById("found").append(...found.map(entry));
document.getElementById("told").textContent = words.length
  ? `${found.length} ${found.length === 1 ? "section holds" : "sections hold"} “${asked}”.`
  : "Write a word into the field above.";
