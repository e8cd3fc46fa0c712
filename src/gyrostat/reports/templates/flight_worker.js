// Worker of the page: receives the program once, then what is to be flown.
let flight = null;
// largest value of each of so many parts of a run
const parts = (values, count) => {
  const size = Math.ceil(values.length / count), kept = new Float32Array(Math.ceil(values.length / size)).fill(NaN);
  values.forEach((v, k) => { const part = Math.floor(k / size); if (!(kept[part] >= v)) kept[part] = v; });
  return kept;
};
async function answered(data) {
  if (data.module) {
    const { instance } = await WebAssembly.instantiate(data.module, {});
    flight = new Flight(instance, data.about, data.shared);
    return [{}, []];
  }
  const began = performance.now(), { nominal, runs, wanted, cloud, concerned } = data, answer = {};
  answer.refused = concerned ? flight.refused(cloud ?? runs, nominal, concerned) : [];
  if (cloud) {
    const flown = cloud.filter((_, k) => answer.refused[k] < 0);
    answer.cloud = [];
    for (let k = 0; k < flown.length; k += flight.lanes)
      for (const run of flight.fly(flown.slice(k, k + flight.lanes), nominal, ["error"]))
        answer.cloud.push({ results: run.results, error: parts(run.signals.error, 120) });
  } else if (!(answer.refused[0] >= 0)) answer.run = flight.fly(runs, nominal, wanted)[0];
  answer.time = performance.now() - began;
  return [answer, Object.values(answer.run?.signals ?? {}).map(each => each.buffer)];
}
// the page hears of no error of a promise in its worker
onmessage = async ({ data }) => {
  try {
    const [answer, moved] = await answered(data);
    postMessage({ ...answer, id: data.id }, moved);
  } catch (error) { postMessage({ failed: String(error) }); }
};
