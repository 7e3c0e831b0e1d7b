// Station whose arm is a separate process behind an observed line. Also a connection to a station
// that can be cut.
import { spawn } from "node:child_process";
import { createConnection, createServer } from "node:net";
import { Station } from "./bench.mjs";

const JOG = 73;
const STOPS = [241, 242, 245];
/** Common clock of traffic and actions, ms. */
export const now = () => performance.timeOrigin + performance.now();

const listening = (server) => new Promise((done) => server.listen(0, "127.0.0.1", () => done(server.address().port)));

/**
 * The arm's line: forwards bytes in both directions, records the times of stops, and counts
 * requests.
 */
class ObservedLine {
  stops = [];
  requestCount = 0;

  async start(arm) {
    this.server = createServer((station) => {
      const upstream = createConnection(arm, "127.0.0.1");
      let rest = Buffer.alloc(0);
      for (const end of [station, upstream]) end.setNoDelay(true).on("error", () => {});
      station.on("data", (data) => {
        rest = this.parse(Buffer.concat([rest, data]));
        upstream.write(data);
      });
      upstream.on("data", (data) => station.write(data));
      station.on("close", () => upstream.destroy());
      upstream.on("close", () => station.destroy());
    });
    return listening(this.server);
  }

  parse(data) {
    while (data.length >= 4) {
      if (data[0] !== 0xaa || data[1] !== 0xaa) {
        data = data.subarray(1);
        continue;
      }
      const length = data[2] + 4;
      if (data.length < length) break;
      const [command, writes] = [data[3], (data[4] & 1) === 1];
      this.requestCount++;
      if (STOPS.includes(command) || (command === JOG && writes && data[6] === 0)) this.stops.push(now());
      data = data.subarray(length);
    }
    return data;
  }

  /** Time from an instant to the next stop, ms; Infinity without one. */
  async stopAfter(when, timeout = 3000) {
    for (const ends = now() + timeout; now() < ends; await new Promise((done) => setTimeout(done, 5))) {
      const stop = this.stops.find((at) => at >= when);
      if (stop !== undefined) return stop - when;
    }
    return Infinity;
  }
}

/** A station with its virtual arm in another process, which the station takes for a real one. */
export class RealArmStation extends Station {
  line = new ObservedLine();

  /** `words` are further arguments of `magician serve`. */
  constructor(program, args = []) {
    super(program, args);
  }

  async start(...more) {
    this.arm = spawn(this.program, ["sim", "--tcp", "127.0.0.1:0"], { stdio: ["ignore", "ignore", "pipe"] });
    let output = "";
    const at = await new Promise((done) =>
      this.arm.stderr.on("data", (piece) => {
        const port = (output += piece).match(/serving tcp:127\.0\.0\.1:(\d+)/)?.[1];
        if (port) done(Number(port));
      }),
    );
    const port = await this.line.start(at);
    await super.start("--port", `tcp:127.0.0.1:${port}`, ...more);
  }

  async end() {
    await super.end();
    this.arm.kill();
    this.line.server.close();
  }
}

/** Connection to a station that can be dropped, or can fall silent without notice. */
export class CuttableLink {
  ends = [];
  isOpen = true;

  async start() {
    this.server = createServer((downstream) => {
      const upstream = createConnection(this.to, "127.0.0.1");
      for (const [one, other] of [
        [downstream, upstream],
        [upstream, downstream],
      ]) {
        one
          .setNoDelay(true)
          .on("error", () => {})
          .on("close", () => other.destroy());
        one.on("data", (data) => this.isOpen && other.write(data));
        this.ends.push(one);
      }
    });
    this.port = await listening(this.server);
  }

  drop() {
    for (const end of this.ends) end.destroy();
    this.server.close();
  }
}
