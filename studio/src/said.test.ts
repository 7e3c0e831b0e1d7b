import { expect, test } from "vitest";
import { names, sentence } from "./i18n";
import { noteText, plainNoteText } from "./run/words";
import said from "./said/zh.json";
import { language } from "./settings";

const outOfReach = {
  template: "{at} is out of reach; the nearest place in reach is {nearest}",
  values: [
    { name: "at", text: "x 400, y 0, z 0" },
    { name: "nearest", text: "x 320, y 0, z 0" },
  ],
};

test("a sentence of the station is filled with its values", () => {
  expect(sentence(outOfReach)).toBe("x 400, y 0, z 0 is out of reach; the nearest place in reach is x 320, y 0, z 0");
  expect(sentence({ template: "nothing to draw" })).toBe("Nothing to draw");
});

test("options have the page's names, and values that are sentences are translated", () => {
  const originalOption = names.option;
  names.option = () => "Scale";
  const values = [
    { name: "name", option: "scale" },
    { name: "accepted", template: "a number {range}", values: [{ name: "range", text: "above 0" }] },
    { name: "value", text: "0" },
  ];
  expect(sentence({ template: "{name} is {accepted}, not {value}", values })).toBe(
    "“Scale” is a number above 0, not 0",
  );
  names.option = originalOption;
});

test("a missing translation falls back to English", async () => {
  language.value = "zh";
  await expect.poll(() => sentence({ template: "nothing to draw" })).toBe(said["nothing to draw"]);
  expect(sentence({ template: "nobody says {this}", values: [{ name: "this", text: "so" }] })).toBe("Nobody says so");
  language.value = "en";
});

const leftOn = {
  code: "left-on",
  text: "the suction cup is still on (switches it off)",
  template: "the suction cup is still on",
  help: { template: "set the point lower, or let it wait longer" },
  remedies: [{ option: "scale", value: 2, effect: "switches it off" }],
};

test("a note beside buttons keeps its advice without the remedies of the buttons", () => {
  const advice = "set the point lower, or let it wait longer";
  expect(plainNoteText(leftOn)).toBe(`The suction cup is still on (${advice})`);
  expect(noteText(leftOn)).toBe(
    `The suction cup is still on (${advice}; “${names.option("scale")}” set to “2”: switches it off)`,
  );
});
