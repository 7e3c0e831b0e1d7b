import { expect, test } from "vitest";
import { base64, linesAt, nameOf } from "./programs";

test("a file's name becomes one that the library takes", () => {
  expect(nameOf("Häuser 2.svg")).toBe("Ha_user 2.svg");
  expect(nameOf("../../etc/passwd")).toBe("_.._etc_passwd");
  expect(nameOf("图.png")).toBe("_.png");
  expect(nameOf("")).toBe("program");
  const long = nameOf(`${"a".repeat(300)}.gcode`);
  expect(long).toHaveLength(80);
  expect(long.endsWith(".gcode")).toBe(true);
});

test("bytes of any length are base64", () => {
  for (const length of [0, 1, 2, 0x8000, 0x8001]) {
    const bytes = Uint8Array.from({ length }, (_, at) => at % 256);
    expect(Uint8Array.from(atob(base64(bytes.buffer)), (sign) => sign.charCodeAt(0))).toEqual(bytes);
  }
});

test("a line comes with its neighbours", async () => {
  const file = new Blob(["one\r\ntwo\nthree\nfour\nfive\nsix"]);
  const around = async (line: number) => (await linesAt(file, line)).map(({ number, text }) => `${number} ${text}`);
  expect(await around(1)).toEqual(["1 one", "2 two", "3 three"]);
  expect(await around(4)).toEqual(["2 two", "3 three", "4 four", "5 five", "6 six"]);
  expect(await around(6)).toEqual(["4 four", "5 five", "6 six"]);
  expect(await around(99)).toEqual([]);
});

test("a line without an end is cut", async () => {
  const [line] = await linesAt(new Blob(["x".repeat(1e6)]), 1);
  expect(line?.text.length).toBeLessThanOrEqual(200);
});
