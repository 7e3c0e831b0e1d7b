// Parsing of typed numbers, for all fields of the page.

/** Largest magnitude that a field accepts. */
const MAX_MAGNITUDE = 1e9;

/** Parses a number with a decimal point or comma; null if the text is not a number. */
export function parseNumber(text: string): number | null {
  const plain = text.trim().replace(/[−–]/, "-").replace(",", ".");
  if (!/^[+-]?(\d+\.?\d*|\.\d+)$/.test(plain)) return null;
  const value = Number(plain);
  return Math.abs(value) <= MAX_MAGNITUDE ? value : null;
}

/**
 * Parses `count` numbers separated by spaces, semicolons or commas; null otherwise. If spaces or
 * semicolons separate them, a comma is a decimal comma.
 */
export function parseNumbers(text: string, count: number): number[] | null {
  const parts = text
    .trim()
    .split(/\s*[;\s]\s*/)
    .map((part) => part.replace(/,$/, ""));
  for (const all of [parts, parts.flatMap((part) => part.split(","))]) {
    const values = all.filter((part) => part !== "").map(parseNumber);
    if (values.length === count && values.every((value) => value !== null)) return values;
  }
  return null;
}
