// Worker of the page: receives the program once, then what is to be flown.
let flight = null;
// largest value of each of so many parts of a run
const parts = (values, count) => {
  const size = Math.ceil(values.length / count), kept = new Float32Array(Math.ceil(values.length / size)).fill(NaN);
  values.forEach((v, k) => { const part = Math.floor(k / size); if (!(kept[part] >= v)) kept[part] = v; });
  return kept;
};
onmessage = async ({ data }) => {
  if (data.module) {
    const { instance } = await WebAssembly.instantiate(data.module, {});
    flight = new Flight(instance, data.about, data.shared);
    postMessage({ ready: true });
    return;
  }
  const began = performance.now(), { nominal, runs, wanted, cloud } = data, answer = { id: data.id };
  if (cloud) {
    answer.cloud = [];
    for (let k = 0; k < cloud.length; k += flight.lanes)
      for (const run of flight.fly(cloud.slice(k, k + flight.lanes), nominal, ["error"]))
        answer.cloud.push({ results: run.results, error: parts(run.signals.error, 200) });
  } else answer.run = flight.fly(runs, nominal, wanted)[0];
  answer.time = performance.now() - began;
  postMessage(answer);
};
