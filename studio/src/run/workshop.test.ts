import { expect, test } from "vitest";
import type { Option } from "../api";
import { optionFault, requireValid, setupOf } from "./workshop";

const option = (name: string) => ({ name, kind: "text", usual: false, choices: [] }) as unknown as Option;

test("a range of power is accepted in the usual notations", () => {
  const power = (text: string) => setupOf([option("power")], { power: text }).power;
  for (const text of ["5-80", "5–80", "5 to 80", "5 到 80", "5..80"]) expect(power(text)).toBe("5..80");
  expect(power("80")).toBe("80");
});

const of = (kind: Option["kind"], name = "speed") => ({ ...option(name), kind, about: name }) as Option;

test("numbers are accepted with a decimal comma or point", () => {
  expect(setupOf([of("number")], { speed: "7,5" })).toEqual({ speed: 7.5 });
  expect(setupOf([of("integer")], { speed: "2" })).toEqual({ speed: 2 });
  expect(setupOf([of("point")], { speed: "200, 10" })).toEqual({ speed: [200, 10] });
  expect(setupOf([of("point")], { speed: "0,5 1,5" })).toEqual({ speed: [0.5, 1.5] });
  expect(setupOf([of("text", "power")], { power: "7,5-60" })).toEqual({ power: "7.5..60" });
});

test("invalid numbers are marked and refused, never truncated", () => {
  for (const [kind, text] of [
    ["number", "30 40"],
    ["number", "abc"],
    ["number", "1e309"],
    ["integer", "2,5"],
    ["place", "1 2"],
  ] as const) {
    expect(setupOf([of(kind)], { speed: text })).toEqual({});
    expect(optionFault(of(kind), text)).not.toBeNull();
    expect(() => requireValid([of(kind)], { speed: text })).toThrow();
  }
  expect(optionFault(of("number"), "")).toBeNull();
});
