// Drawing with the pen: on the sheet first, then on the paper.
import { t } from "../i18n";
import { Workshop } from "./workshop";

export const Draw = () => (
  <Workshop tool="pen" name={t("nav.draw")} hint={t("draw.empty")} first={["passes", "speed"]} />
);
