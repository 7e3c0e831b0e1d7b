import { t } from "../i18n";
import * as store from "../store";
import { Dialogs } from "./dialogs";
import { Alarms, Header, LastActivity, LinkLost, UpdateOffer } from "./header";
import { Panel, Strip } from "./routes";
import { SidePanel } from "./sidepanel";

export function App() {
  const route = store.route.value;
  return (
    <>
      <Header />
      <Strip />
      <main class={`route-${route}`}>
        <h1 class="unseen">{`${t("app")}: ${t(`nav.${route}`)}`}</h1>
        <UpdateOffer />
        <LinkLost />
        <LastActivity />
        <Alarms />
        <Panel />
      </main>
      <SidePanel />
      <Dialogs />
    </>
  );
}
