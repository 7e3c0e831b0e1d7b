import { expect, test } from "vitest";

type Sentences = Record<string, string>;
const panels = import.meta.glob<Record<string, Sentences>>("./**/*.json", { eager: true, import: "default" });
const pairs: Array<[string, Sentences, Sentences]> = [];
for (const [file, texts] of Object.entries(panels)) {
  if ("en" in texts && "zh" in texts) pairs.push([file, texts.en as Sentences, texts.zh as Sentences]);
}

/** The values that a sentence takes. */
const values = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name).toSorted();

// That no key is missing is found by the compiler; the sentences of the frame are judged by xtask, with those of the station.
test("there are sentences of panels", () => expect(pairs.length).toBeGreaterThan(5));

test.each(pairs)("the sentences of %s take the same values in both languages", (_, english, chinese) => {
  for (const [key, text] of Object.entries(english))
    expect([key, values(chinese[key] ?? "")]).toEqual([key, values(text)]);
});
