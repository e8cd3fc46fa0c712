// Workers of the page that flies. One that fails, or that does not answer in time, is ended; the next flight starts another one.
// Longest wait for an answer, ms. It doubles when it was too short: a run may be long, a machine slow
let patience = 30000;
// address: of the script of the worker; workers: those that live, to which it is added; start: its first message
function flightWorker(address, workers, start) {
  const made = new Worker(address), waiting = new Map();
  let number = 0, fault = null;
  const settle = (id, how, value) => { const { limit, [how]: call } = waiting.get(id); clearTimeout(limit); waiting.delete(id); call(value); };
  const lost = error => {
    fault = error;
    made.terminate();
    if (workers.includes(made)) workers.splice(workers.indexOf(made), 1);
    for (const id of [...waiting.keys()]) settle(id, "reject", error);
  };
  made.onerror = event => { event.preventDefault(); lost(new Error(event.message || "its worker cannot start")); };
  made.onmessage = ({ data }) => { if (data.failed) lost(new Error(data.failed)); else settle(data.id, "resolve", data); };
  made.onmessageerror = () => lost(new Error("its worker's answer cannot be read"));
  made.ask = message => fault ? Promise.reject(fault) : new Promise((resolve, reject) => {
    const id = ++number, wait = patience;
    const limit = setTimeout(() => { patience = 2 * wait; lost(new Error(`its worker gave no answer in ${wait / 1000} s`)); }, wait);
    waiting.set(id, { limit, resolve, reject }); made.postMessage({ ...message, id });
  });
  made.ready = made.ask(start);
  made.ready.catch(() => {}); // said when it is asked
  workers.push(made);
  return made;
}
