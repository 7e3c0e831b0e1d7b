// Test of arm.wasm and files.wasm together under Node: the plans of all samples equal the native ones byte for byte.
//
//     node files.mjs arm.wasm files.wasm FOLDER
//
// FOLDER contains the samples, each with its native plan (NAME.made) or error (NAME.error).

import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { load } from "./shim.mjs";
import { load as loadReader } from "./reader.mjs";

const [armFile, filesFile, folder] = process.argv.slice(2);
let clock = 5_000;
const module = await load(readFileSync(armFile), () => clock);
const read = await loadReader(readFileSync(filesFile));
const station = module.open({ arms: [{ name: "arm", sim: { speed: 1 } }] });
const [utf8, asked] = [new TextDecoder(), { files: 0, spoilt: false }];
let ids = 0;

function turn() {
  const next = station.turn();
  const texts = [];
  for (let what = station.out(); what; what = station.out()) {
    if (what.kind === "text") texts.push(JSON.parse(what.payload));
    else if (what.kind === "file") {
      const id = new DataView(what.payload.buffer, what.payload.byteOffset).getUint32(0, true);
      const request = what.payload.slice(4);
      asked.files += 1;
      // Pretend that the request is from another build, whose format differs.
      if (asked.spoilt) request[0] ^= 1;
      const answer = read(request);
      if (asked.spoilt) answer[0] ^= 1;
      station.fileIn(id, answer);
    }
  }
  clock = next;
  return texts;
}

function call(method, params = {}) {
  const id = ++ids;
  station.rpc(1, JSON.stringify({ jsonrpc: "2.0", id, method, params }));
  for (let turns = 0; turns < 20_000; turns += 1) {
    const answer = turn().find((text) => text.id === id);
    if (answer) return answer;
  }
  throw new Error(`${method} is not answered`);
}

for (let own = []; own.length === 0; ) own = turn();
call("session.hello", { client: { name: "node" } });
const names = readdirSync(folder);
const natively = new Map(names.filter((name) => /\.(made|error)$/.test(name)).map((name) => [name, readFileSync(join(folder, name))]));
let [plans, errors] = [0, 0];
for (const name of names.filter((name) => !natively.has(name))) {
  const why = station.programIn(name, readFileSync(join(folder, name)));
  if (why) throw new Error(`${name}: ${utf8.decode(why)}`);
  const to = "made.plan.json";
  const answer = call("program.convert", { name, to });
  const made = answer.error ? Buffer.from(answer.error.message) : Buffer.from(station.programOut(to));
  const wanted = natively.get(`${name}.${answer.error ? "error" : "made"}`);
  if (!wanted || !wanted.equals(made)) throw new Error(`${name}: ${answer.error?.message ?? "another plan"} than natively`);
  answer.error ? (errors += 1) : (plans += 1);
  call("program.delete", { name });
}
if (asked.files < plans / 2) throw new Error("files.wasm was not asked");
asked.spoilt = true;
station.programIn("a.nc", Buffer.from("G90 G1 X200 Y0 Z0 F600\n"));
const { error } = call("program.convert", { name: "a.nc", to: "b.plan.json" });
if (error?.data?.kind !== "unsupported" || !error.message.includes("reload the page")) throw new Error(`another build's: ${JSON.stringify(error)}`);
console.log(`${plans} plans by both modules are the native ones, ${errors} errors too; ${asked.files} files read`);
