import { expect, test } from "vitest";
import type { Job } from "../api";
import { RpcError } from "../client";
import { hearRefusal, keepOrder, orderOf } from "./again";

const job = (id: string) => ({ job: id }) as Job;
const code = "nothing-to-resume";

test("a job without a journal can be restarted by the page that started it", () => {
  keepOrder("one", { program: "a.svg" }, "a.svg");
  expect(orderOf(job("one"))).toBeNull();
  hearRefusal("one", new RpcError(-32004, "the arm is busy", { code: "busy" }));
  expect(orderOf(job("one"))).toBeNull();
  hearRefusal("one", new RpcError(-32000, "nothing to resume", { code }));
  expect(orderOf(job("one"))).toEqual({ order: { program: "a.svg" }, title: "a.svg" });
  hearRefusal("other", new RpcError(-32000, "nothing to resume", { code }));
  expect(orderOf(job("other"))).toBeNull();
});
