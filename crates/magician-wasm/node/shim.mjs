// Wrapper of arm.wasm that takes text and bytes instead of addresses, and provides its imports: the page's clock (clock 0 is the calendar),
// random numbers, and an output for panics. The module never sleeps, so `poll_oneoff`, in which a runtime would, is an error.
const utf8 = new TextDecoder();
const KINDS = ["text", "frame", "line", "close", "trace", "file"];
const fail = (why) => { throw new Error(why); };

// Loads the module. `now` is the monotonic clock of the page, ms; `unix_zero` of the configuration is the Unix time at its zero.
export async function load(source, now = () => performance.now()) {
  let wasm;
  const bytes = (at, count) => new Uint8Array(wasm.memory.buffer, at, count);
  const view = () => new DataView(wasm.memory.buffer);
  const end = (what) => () => fail(`arm.wasm: ${what}`);
  const wasi = {
    clock_time_get: (clock, _precision, at) => (view().setBigUint64(at, BigInt(Math.round((now() + (clock === 0 ? performance.timeOrigin : 0)) * 1000)) * 1000n, true), 0),
    random_get: (at, count) => (crypto.getRandomValues(bytes(at, count)), 0),
    environ_sizes_get: (count, size) => (view().setUint32(count, 0, true), view().setUint32(size, 0, true), 0),
    environ_get: () => 0,
    sched_yield: () => 0,
    poll_oneoff: end("it sleeps"),
    proc_exit: end("it has ended"),
    fd_write(_file, list, count, written) {
      let sum = 0;
      for (let at = list; at < list + 8 * count; at += 8) {
        sum += view().getUint32(at + 4, true);
        console.error(utf8.decode(bytes(view().getUint32(at, true), view().getUint32(at + 4, true))));
      }
      view().setUint32(written, sum, true);
      return 0;
    },
  };
  wasm = (await WebAssembly.instantiate(source, { wasi_snapshot_preview1: wasi })).instance.exports;
  const hand = (what, act) => {
    const given = typeof what === "string" ? new TextEncoder().encode(what) : what;
    const at = wasm.alloc(given.length) >>> 0;
    if (at === 0 && given.length > 0) fail("there is no memory for it");
    bytes(at, given.length).set(given);
    const answer = act(at, given.length);
    wasm.free(at, given.length);
    return answer;
  };
  const shown = (place) => place === 0n ? null : bytes(Number(BigInt.asUintN(32, place >> 32n)), Number(BigInt.asUintN(32, place))).slice();
  function out(handle) {
    const what = shown(wasm.station_out(handle));
    if (what === null) return null;
    const payload = what[0] === 0 ? utf8.decode(what.subarray(3)) : what.subarray(3);
    return { kind: KINDS[what[0]], session: what[1] | (what[2] << 8), payload };
  }
  function open(config) {
    const handle = hand(JSON.stringify(config), wasm.station_open) >>> 0;
    if (handle === 0) fail(JSON.parse(out(0).payload).error.message);
    return {
      rpc: (session, text) => hand(text, (at, count) => wasm.station_rpc(handle, session, at, count)),
      turn: () => wasm.station_turn(handle, now() * 1000) / 1000,
      out: () => out(handle),
      lineIn: (what) => hand(what, (at, count) => wasm.line_in(handle, at, count)),
      fileIn: (id, what) => hand(what, (at, count) => wasm.file_in(handle, id, at, count)),
      programIn: (name, what) => hand(name, (of, letters) => hand(what, (at, count) => shown(wasm.program_in(handle, of, letters, at, count)))),
      programOut: (name) => hand(name, (of, letters) => shown(wasm.program_out(handle, of, letters))),
      lineIs: (there) => (there ? wasm.line_found(handle) : wasm.line_lost(handle)),
    };
  }
  return { open, memory: wasm.memory };
}
