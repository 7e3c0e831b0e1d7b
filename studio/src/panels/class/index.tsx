// Class, by user: the sign-in page, a pupil's page, or the teacher's page.
import { hasClass } from "../../class";
import { t } from "../../i18n";
import * as store from "../../store";
import { Card } from "../../ui/parts";
import { Site } from "../site";
import { Conduct } from "./conduct";
import { ClassEditor } from "./editor";
import { StationsCard } from "./hub";
import { PupilPage } from "./pupil";
import { Pupils } from "./pupils";
import { Results } from "./results";
import { SignIn } from "./signin";
import { Slips, slips } from "./slips";
import "./class.css";

function Teacher() {
  if (slips.value !== null) return <Slips />;
  return hasClass.value ? (
    <>
      <Conduct />
      <Site pictures={false} />
      {store.hub.value ? <StationsCard /> : <Pupils />}
      <Results />
      <ClassEditor />
    </>
  ) : (
    <ClassEditor />
  );
}

export function Class() {
  const audience = store.audience.value;
  const role = store.role.value;
  return (
    <div class="columns class-page">
      {audience === "door" ? (
        <SignIn />
      ) : audience === "pupil" || (hasClass.value && role === "student") ? (
        store.hub.value ? (
          <StationsCard />
        ) : (
          <PupilPage />
        )
      ) : role === "teacher" ? (
        <Teacher />
      ) : (
        <Card title={t("class.title")} class="arms">
          <p class="hint">{t(store.socket.value === "up" ? "class.none" : "link.connecting")}</p>
        </Card>
      )}
    </div>
  );
}
