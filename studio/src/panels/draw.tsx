// Drawing with the pen: on the sheet first, then on the paper.
import { t } from "../i18n";
import { JobCard } from "./job";
import { PartsCard } from "./partslist";
import { Presets } from "./presets";
import { Sheet } from "./sheet";
import { OptionsCard, Start, useWorkshop, What } from "./workshop";

export function Draw() {
  useWorkshop("pen");
  return (
    <div class="workshop">
      <Sheet hint={t("draw.empty")} />
      <div class="workshop-do" role="group" aria-label={t("nav.draw")}>
        <What />
        <Start />
        <JobCard />
        <OptionsCard first={["passes", "speed"]} />
        <PartsCard />
        <Presets />
      </div>
    </div>
  );
}
