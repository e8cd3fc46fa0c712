// Fills the list of versions from `gyrostatVersions`: folder beside this one -> its pages. It needs no server.
(() => {
  const { version, root, page } = document.currentScript.dataset, every = window.gyrostatVersions ?? {};
  const label = document.querySelector(".versions label"), select = label.querySelector("select");
  if (Object.keys(every).length < 2) return;
  for (const name in every) select.add(new Option(name, name, false, name === version));
  select.onchange = () => {
    const same = every[select.value].includes(page) ? page : "index.html";
    location.href = `${root}../${select.value}/${same}`;
  };
  label.hidden = false;
})();
