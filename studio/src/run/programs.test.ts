import { beforeEach, expect, test, vi } from "vitest";

const shelf = new Map<string, { data: string; modified: number }>();
let clock = 0;
vi.mock("../session", () => ({
  call: async (method: string, { name, data }: { name: string; data: string }) => {
    if (method === "program.put") shelf.set(name, { data, modified: ++clock });
    if (method === "program.get") return shelf.get(name);
    if (method !== "program.list") return {};
    const programs = [...shelf].map(([name, { data, modified }]) => ({ name, bytes: atob(data).length, modified }));
    return { programs };
  },
  fileEndpoint: () => null,
  localFile: () => null,
}));
const { base64, storeUnused, linesAt, libraryName, unusedName } = await import("./programs");
beforeEach(() => shelf.clear());

test("a file name is converted to a valid library name", () => {
  expect(libraryName("Häuser 2.svg")).toBe("Hauser 2.svg");
  expect(libraryName("../../etc/passwd")).toBe("_.._etc_passwd");
  expect(libraryName("")).toBe("program");
  const long = libraryName(`${"a".repeat(300)}.gcode`);
  expect(long).toHaveLength(80);
  expect(long.endsWith(".gcode")).toBe(true);
});

test("bytes of any length are base64", () => {
  for (const length of [0, 1, 2, 0x8000, 0x8001]) {
    const bytes = Uint8Array.from({ length }, (_, at) => at % 256);
    expect(Uint8Array.from(atob(base64(bytes.buffer)), (sign) => sign.charCodeAt(0))).toEqual(bytes);
  }
});

test("linesAt returns a line with its neighbours", async () => {
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

test("names in non-Latin scripts stay distinct", () => {
  const files = [
    "日本語.svg",
    "中文.svg",
    "中.svg",
    "Рисунок.svg",
    "مرحبا.svg",
    "plan 1 中.svg",
    "plan 1 文.svg",
    "Straße.svg",
  ];
  const names = files.map(libraryName);
  expect(new Set(names).size).toBe(files.length);
  for (const name of names) expect(name).toMatch(/^[A-Za-z0-9][A-Za-z0-9._ -]{0,75}-[0-9a-z]{4}\.svg$/);
  expect(libraryName("日本語.svg")).toBe(libraryName("日本語.svg"));
  expect(libraryName(`${"中".repeat(300)}.svg`).length).toBeLessThanOrEqual(80);
  expect(libraryName("中")).toMatch(/^program-....$/);
});

test("files that come with the page replace no program", async () => {
  const mine = btoa("mine");
  shelf.set("star.plt", { data: mine, modified: 1 });
  expect(await storeUnused("star.plt", new Blob(["IN;"]))).toBe("star 2.plt");
  expect(shelf.get("star.plt")?.data).toBe(mine);
  expect(await storeUnused("star 2.plt", new Blob(["IN;"]))).toBe("star 2.plt");
  expect(await unusedName("star.plt")).toBe("star 3.plt");
  expect(await unusedName("other.plt")).toBe("other.plt");
});
