// Test of arm.wasm under Node: moves and jogs a virtual arm and prints its pose.
//
//     node try.mjs arm.wasm

import { readFileSync } from "node:fs";
import { load } from "./shim.mjs";

const assert = (holds, what) => {
  if (!holds) throw new Error(what);
};
// The script advances the clock itself, so nothing waits.
let clock = 5_000;
const module = await load(readFileSync(process.argv[2]), () => clock);

for (const wrong of [{}, { arms: [{ name: "arm", sim: { speed: 0 } }] }]) {
  let why;
  try {
    module.open(wrong);
  } catch (error) {
    why = error.message;
  }
  assert(why, "a bad configuration is refused");
  console.log(`refused: ${why}`);
}

const station = module.open({ arms: [{ name: "arm", sim: { speed: 1 } }], unix_zero: 1_700_000_000 });
const notices = [];
let frames = 0;
let ids = 0;

// Advances the clock to the next turn and returns the texts that were output.
function turn() {
  const next = station.turn();
  assert(next > clock && next <= clock + 50, `the next turn is due at ${next}, and it is ${clock}`);
  const texts = [];
  for (let what = station.out(); what; what = station.out()) {
    if (what.kind === "text") texts.push(JSON.parse(what.payload));
    else if (what.kind === "frame") frames += 1;
    else throw new Error(`${what.kind} comes out`);
  }
  clock = next;
  notices.push(...texts.filter((text) => text.method));
  return texts.filter((text) => !text.method);
}

function call(method, params = {}) {
  const id = ++ids;
  station.rpc(1, JSON.stringify({ jsonrpc: "2.0", id, method, params }));
  for (let turns = 0; turns < 20_000; turns += 1) {
    const answer = turn().find((text) => text.id === id);
    if (answer) {
      assert(!answer.error, `${method}: ${JSON.stringify(answer.error)}`);
      return answer.result;
    }
  }
  throw new Error(`${method} is not answered`);
}

let own = [];
while (own.length === 0) own = turn();
assert(own[0].ready, JSON.stringify(own));
console.log(`ready: ${JSON.stringify(own[0].arms)}`);
call("session.hello", { client: { name: "node" } });
call("lease.acquire");
call("arm.subscribe", { rate: 20, frame: "binary" });
const to = [220, 40, 30, 0];
const there = call("arm.move", { to });
assert(["x", "y", "z"].every((name, at) => Math.abs(there[name] - to[at]) < 0.01), JSON.stringify(there));
const { jog } = call("jog.start", { axis: "y+" });
for (let kept = 0; kept < 10; kept += 1) {
  station.rpc(1, JSON.stringify({ jsonrpc: "2.0", method: "jog.keep", params: { jog } }));
  for (const until = clock + 60; clock < until; ) turn();
}
const ended = () => notices.find((text) => text.method === "jog.ended");
assert(!ended(), "it is kept");
const last = clock;
while (!ended()) turn();
assert(ended().params.why === "not-kept" && clock - last < 300, JSON.stringify(ended()));
for (const until = clock + 1000; clock < until; ) turn();
const pose = call("arm.state");
assert(!pose.moving && pose.y > there.y + 2, JSON.stringify(pose));
assert(frames > 20, `${frames} frames`);
const shown = ["x", "y", "z", "r"].map((name) => `${name} ${pose[name].toFixed(2)}`);
console.log(`${shown.join(" ")} after ${((clock - 5_000) / 1000).toFixed(1)} s; ${frames} frames`);
console.log(`memory: ${(module.memory.buffer.byteLength / 1e6).toFixed(1)} MB`);
