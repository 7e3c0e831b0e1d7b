// Drawing with the pen: arranged on the sheet, then drawn on the paper.
import { t } from "../i18n";
import { benches } from "../run/bench";
import { WorkshopPanel } from "./workshop";

export const Draw = () => (
  <WorkshopPanel bench={benches.pen} name={t("nav.draw")} hint={t("draw.empty")} first={["passes", "speed"]} />
);
