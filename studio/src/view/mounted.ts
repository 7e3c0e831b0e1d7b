// Which tool the arm carries, as far as anything tells.
import type { State } from "../api";
import type { ToolName } from "./body";

/**
 * What leaves lines in the world of a virtual arm is certain. Else it is the tool that was chosen; cup and gripper have
 * the same place on the arm, and the one that was switched is there.
 */
export function mountedOf(tool: State["tool"] | undefined, draws: string | null | undefined): ToolName | null {
  if (draws === "pen" || draws === "laser") return draws;
  if (tool === undefined) return null;
  const isCup = tool.name === "suction" || tool.name === "gripper" || tool.name === null;
  if (isCup && tool.suction === true) return "suction";
  if (isCup && (tool.gripper === "open" || tool.gripper === "closed")) return "gripper";
  return tool.name;
}
