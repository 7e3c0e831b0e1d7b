import { expect, test } from "vitest";
import type { Job } from "../api";
import { RpcError } from "../client";
import { noteRefusal, restartOrder, storeOrder } from "./restart";

const job = (id: string) => ({ job: id }) as Job;
const code = "nothing-to-resume";

test("a job without a journal can be restarted by the page that started it", () => {
  storeOrder("one", { program: "a.svg" }, "a.svg");
  expect(restartOrder(job("one"))).toBeNull();
  noteRefusal("one", new RpcError(-32004, "the arm is busy", { code: "busy" }));
  expect(restartOrder(job("one"))).toBeNull();
  noteRefusal("one", new RpcError(-32000, "nothing to resume", { code }));
  expect(restartOrder(job("one"))).toEqual({ order: { program: "a.svg" }, title: "a.svg" });
  noteRefusal("other", new RpcError(-32000, "nothing to resume", { code }));
  expect(restartOrder(job("other"))).toBeNull();
});
