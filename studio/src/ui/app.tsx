import { Arms } from "../panels/arms";
import { Move } from "../panels/move";
import { Settings } from "../panels/settings";
import { t } from "../i18n";
import * as store from "../store";
import { Dialogs } from "./dialogs";
import { Alarms, Header, LinkLost } from "./header";

const PANELS = { move: Move, arms: Arms, settings: Settings };

export function App() {
  const Panel = PANELS[store.route.value];
  return (
    <>
      <Header />
      <main class={`route-${store.route.value}`}>
        <h1 class="unseen">{`${t("app")}: ${t(`nav.${store.route.value}`)}`}</h1>
        <LinkLost />
        <Alarms />
        <Panel />
      </main>
      <Dialogs />
    </>
  );
}
