// Arms of the station, the connection to it, and the log.

import { attempt } from "../actions";
import { t } from "../i18n";
import { clock, lines, save } from "../log";
import { canTrace, trace } from "../session";
import { Button, Card } from "../ui/parts";
import { Connect } from "./connect";
import { Site } from "./site";

function Log() {
  const all = lines.value;
  const text = () => all.map((line) => `${line.at.toISOString()}  ${line.text}\n`).join("");
  return (
    <Card
      title={t("log.title")}
      class="log-card"
      more={
        <>
          {canTrace() ? (
            <Button
              id="log-export"
              class="quiet small"
              press={() => attempt(async () => save("magician.pcapng", await trace(), "application/octet-stream"))}
            >
              {t("log.bytes")}
            </Button>
          ) : null}
          <Button
            class="quiet small"
            off={all.length === 0}
            text={t("log.export")}
            press={() => save("magician-log.txt", text())}
          />
        </>
      }
    >
      <div class="log" role="log" aria-label={t("log.title")} tabIndex={0} data-testid="log">
        {all.length === 0 ? <p class="hint">{t("log.empty")}</p> : null}
        {all.map((line, at) => (
          <p key={at}>
            <time dateTime={line.at.toISOString()}>{clock(line.at)}</time> {line.text}
          </p>
        ))}
      </div>
    </Card>
  );
}

export function Arms() {
  return (
    <div class="columns">
      <Site />
      <Connect />
      <Log />
    </div>
  );
}
