import { expect, test } from "vitest";
import { exclusive } from "./parts";

test("a press is ignored while the previous one is pending", async () => {
  const does = exclusive();
  let [pressed, done] = [0, () => {}];
  const press = () => {
    pressed++;
    return new Promise<void>((over) => (done = over));
  };
  does(press);
  does(press);
  expect(pressed).toBe(1);
  done();
  await Promise.resolve();
  does(press);
  expect(pressed).toBe(2);
});

test("a press works again after a failure, and always if it completes at once", async () => {
  const does = exclusive();
  let pressed = 0;
  does(() => {
    pressed++;
    return Promise.reject(new Error("refused"));
  });
  await Promise.resolve();
  for (let nth = 0; nth < 3; nth++) does(() => void pressed++);
  expect(pressed).toBe(4);
});
