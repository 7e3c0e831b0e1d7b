import { t } from "../i18n";
import * as store from "../store";
import { Beside } from "./beside";
import { Dialogs } from "./dialogs";
import { Alarms, Header, Left, LinkLost, Update } from "./header";
import { Panel, Strip } from "./routes";

export function App() {
  const route = store.route.value;
  return (
    <>
      <Header />
      <Strip />
      <main class={`route-${route}`}>
        <h1 class="unseen">{`${t("app")}: ${t(`nav.${route}`)}`}</h1>
        <Update />
        <LinkLost />
        <Left />
        <Alarms />
        <Panel />
      </main>
      <Beside />
      <Dialogs />
    </>
  );
}
