/** How many things are near, and how near the nearest is. */
export default function (element, { on }) {
  const words = document.createElement("p");
  words.dataset.testid = "near-things";
  words.textContent = "No count yet: desire CountNearThings.";
  element.append(words);
  return on("channel/near_things", ({ message }) => {
    const nearest = message.nearest_m === null ? "" : `, the nearest ${message.nearest_m.toFixed(2)} m away`;
    words.textContent = `${message.count} near${nearest}`;
  });
}
