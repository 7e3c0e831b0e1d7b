import { expect, test } from "vitest";
import { namesOf, repeatedIn } from "./make";

test("duplicate names are found regardless of case", () => {
  expect(repeatedIn("Ada\nBen\nada")).toBe("ada");
  expect(repeatedIn("Ada, Ben; Ada")).toBe("Ada");
  expect(repeatedIn("Ada\nBen\nAda B")).toBe(undefined);
  expect(namesOf(" Ada \n\nChen   Li")).toEqual(["Ada", "Chen Li"]);
});
