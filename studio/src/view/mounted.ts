// Mounted tool, as far as it can be known.
import type { State } from "../api";
import type { ToolName } from "./body";

/**
 * Mounted tool. A tool that draws in the world of a virtual arm is certain. Otherwise it is the
 * configured tool, except that cup and gripper share a mounting position, so the tool that was
 * switched on counts as mounted.
 */
export function mountedOf(tool: State["tool"] | undefined, draws: string | null | undefined): ToolName | null {
  if (draws === "pen" || draws === "laser") return draws;
  if (tool === undefined) return null;
  const isCup = tool.name === "suction" || tool.name === "gripper" || tool.name === null;
  if (isCup && tool.suction === true) return "suction";
  if (isCup && (tool.gripper === "open" || tool.gripper === "closed")) return "gripper";
  return tool.name;
}
