// The switch that arms the laser: beside every button by which something that burns begins, or goes on.
import { isArmed } from "../run/burn";
import * as jobs from "../run/jobs";
import { Switch } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./armlaser.json";

const w = sentencesOf(texts);

/** Switch that arms the laser; hidden if the job does not burn. `whyNoControl` is the id of the reason shown while it is off. */
export function ArmLaser({ id, burns, why }: { id: string; burns: boolean; why: string }) {
  if (!burns) return null;
  return (
    <Switch
      id={id}
      label={w("laser.arm")}
      on={isArmed.value}
      off={jobs.whyNoControl.value !== null}
      why={why}
      danger
      flip={(on) => (isArmed.value = on)}
    />
  );
}
