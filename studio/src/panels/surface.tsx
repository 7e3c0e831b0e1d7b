// Work surface, on the page that has the jog pad anyway.
import { useEffect } from "preact/hooks";
import * as surface from "../run/surface";
import { TouchOff } from "./touch";

export function Surface() {
  useEffect(surface.follow, []);
  return <TouchOff />;
}
