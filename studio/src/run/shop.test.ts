import { expect, test } from "vitest";
import type { Option } from "../api";
import { setupOf } from "./shop";

const option = (name: string) => ({ name, kind: "text", usual: false, choices: [] }) as unknown as Option;

test("a range of power is taken as people write it", () => {
  const power = (text: string) => setupOf([option("power")], { power: text }).power;
  for (const text of ["5-80", "5–80", "5 to 80", "5 到 80", "5..80"]) expect(power(text)).toBe("5..80");
  expect(power("80")).toBe("80");
});
