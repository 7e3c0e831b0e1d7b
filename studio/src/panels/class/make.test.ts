import { expect, test } from "vitest";
import { namesOf, repeatedIn } from "./make";

test("two pupils of one name are found, in whichever letters they are written", () => {
  expect(repeatedIn("Ada\nBen\nada")).toBe("ada");
  expect(repeatedIn("Ada, Ben; Ada")).toBe("Ada");
  expect(repeatedIn("Ada\nBen\nAda B")).toBe(undefined);
  expect(namesOf(" Ada \n\nChen   Li")).toEqual(["Ada", "Chen Li"]);
});
