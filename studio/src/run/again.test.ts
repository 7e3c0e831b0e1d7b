import { expect, test } from "vitest";
import type { Job } from "../api";
import { RpcError } from "../client";
import { hearRefusal, keepOrder, orderOf } from "./again";

const job = (id: string) => ({ job: id }) as Job;
const template = "nothing to resume: no journal says how far the job came; start it from the beginning";

test("a job that left no trace is offered from its beginning, by the page that started it", () => {
  keepOrder("one", { program: "a.svg" }, "a.svg");
  expect(orderOf(job("one"))).toBeNull();
  hearRefusal("one", new RpcError(-32004, "the arm is busy", { template: "the arm is busy" }));
  expect(orderOf(job("one"))).toBeNull();
  hearRefusal("one", new RpcError(-32004, template, { template }));
  expect(orderOf(job("one"))).toEqual({ order: { program: "a.svg" }, title: "a.svg" });
  hearRefusal("other", new RpcError(-32004, template, {}));
  expect(orderOf(job("other"))).toBeNull();
});
