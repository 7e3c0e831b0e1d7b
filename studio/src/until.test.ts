import { signal } from "@preact/signals";
import { expect, test, vi } from "vitest";
import { until } from "./until";

test("until resolves at once if the condition already holds", async () => expect(await until(() => true)).toBe(true));

test("until resolves when the condition holds and stops evaluating it", async () => {
  const value = signal(0);
  const is = vi.fn(() => value.value === 2);
  const found = until(is);
  value.value = 1;
  value.value = 2;
  expect(await found).toBe(true);
  const looks = is.mock.calls.length;
  value.value = 3;
  expect(is.mock.calls.length).toBe(looks);
});

test("until resolves to false after its timeout", async () => {
  vi.useFakeTimers();
  const value = signal(false);
  const found = until(() => value.value, 100);
  vi.advanceTimersByTime(100);
  expect(await found).toBe(false);
  vi.useRealTimers();
});
