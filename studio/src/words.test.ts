import { expect, test } from "vitest";

type Sentences = Record<string, string>;
const panels = import.meta.glob<Record<string, Sentences>>("./**/*.json", { eager: true, import: "default" });
const pairs: Array<[string, Sentences, Sentences]> = [];
for (const [file, texts] of Object.entries(panels)) {
  if ("en" in texts && "zh" in texts) pairs.push([file, texts.en as Sentences, texts.zh as Sentences]);
}

/** Parameters of a sentence. */
const values = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name).toSorted();

// The compiler finds missing keys. xtask checks the sentences of the frame and of the station.
test("there are sentences of panels", () => expect(pairs.length).toBeGreaterThan(5));

test.each(pairs)("the sentences of %s take the same values in both languages", (_, english, chinese) => {
  for (const [key, text] of Object.entries(english))
    expect([key, values(chinese[key] ?? "")]).toEqual([key, values(text)]);
});
