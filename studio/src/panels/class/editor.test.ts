import { expect, test } from "vitest";
import { duplicateName, parseNames } from "./editor";

test("duplicate names are found regardless of case", () => {
  expect(duplicateName("Ada\nBen\nada")).toBe("ada");
  expect(duplicateName("Ada, Ben; Ada")).toBe("Ada");
  expect(duplicateName("Ada\nBen\nAda B")).toBe(undefined);
  expect(parseNames(" Ada \n\nChen   Li")).toEqual(["Ada", "Chen Li"]);
});
