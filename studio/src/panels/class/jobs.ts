// Programs that wait for an arm, in words.
import { t, told } from "../../i18n";

/** Why a program waits; a reason that the page does not know is said as it came. */
export const reasonOf = (reason: string | null): string => (reason === null ? t("class.reason.turn") : told(`class.reason.${reason}`, reason));
