"use strict";
// One instance of the simulator in a thread of its own: it judges the swarm that is watched, or counts how
// replicates of a cell end.

const tasks = {
  load: async ({ module }) => {
    simulator = (await WebAssembly.instantiate(module, {})).exports;
    return {};
  },
  open: ({ scene, replicate }) => {
    put(scene);
    got(simulator.open(BigInt(replicate)));
    return {};
  },
  // The swarm is the watched one, bit for bit, so its steps need not be sent.
  judge: ({ n_steps }) => {
    simulator.step(Math.max(n_steps - simulator.n_steps(), 0));
    return { judgement: JSON.parse(got(simulator.judge())) };
  },
  count: ({ scene, from, to }) => {
    put(scene);
    return { counts: JSON.parse(got(simulator.count(BigInt(from), BigInt(to)))) };
  },
};

// Whatever goes wrong is answered: who asked waits for it.
onmessage = async ({ data }) => {
  let answer;
  try {
    answer = await tasks[data.task](data);
  } catch (error) {
    answer = { refusal: error.message };
  }
  postMessage({ id: data.id, ...answer });
};
