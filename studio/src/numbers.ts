// Numbers as people type them, for every field of the page.

/** Nothing that is typed here is larger than this. */
const MOST = 1e9;

/** A number with a point or a comma before its digits; null where it is none. */
export function numberOf(text: string): number | null {
  const plain = text.trim().replace(/[−–]/, "-").replace(",", ".");
  if (!/^[+-]?(\d+\.?\d*|\.\d+)$/.test(plain)) return null;
  const value = Number(plain);
  return Math.abs(value) <= MOST ? value : null;
}

/**
 * So many numbers, parted by spaces, semicolons or commas; null where they are others, or not so many. A comma belongs to a
 * number where spaces or semicolons part them already.
 */
export function numbersOf(text: string, count: number): number[] | null {
  const parts = text
    .trim()
    .split(/\s*[;\s]\s*/)
    .map((part) => part.replace(/,$/, ""));
  for (const all of [parts, parts.flatMap((part) => part.split(","))]) {
    const values = all.filter((part) => part !== "").map(numberOf);
    if (values.length === count && values.every((value) => value !== null)) return values;
  }
  return null;
}
