// Gallery of examples: each opens in its panel, and runs at once on a virtual arm.
import { useSignal } from "@preact/signals";
import { EXAMPLES, type Example } from "../gallery/examples";
import { canAutostart, openExample, whyNotOpen } from "../gallery/open";
import { t } from "../i18n";
import { Card, Reason } from "../ui/parts";
import { sentencesOf } from "../words";
import "./gallery.css";
import texts from "./gallery.json";

const w = sentencesOf(texts);

function Tile({ example, off, opens }: { example: Example; off: boolean; opens: () => void }) {
  const { name, panel } = example;
  return (
    <li>
      <button
        type="button"
        class="example"
        data-testid={`gallery-${name}`}
        disabled={off}
        aria-describedby={off ? "gallery-why" : undefined}
        onClick={opens}
      >
        <img src={`assets/example-${name}.webp`} alt="" width="320" height="200" loading="lazy" />
        <b>{w(`${name}.title`)}</b>
        <span class="hint">{w(`${name}.text`)}</span>
        <small>{t(`nav.${panel}`)}</small>
      </button>
    </li>
  );
}

export function Gallery() {
  const opening = useSignal(false);
  const reason = whyNotOpen.value;
  const opens = async (example: Example) => {
    opening.value = true;
    await openExample(example);
    opening.value = false;
  };
  return (
    <Card title={w("gallery.title")} class="gallery-card" data-testid="gallery">
      <p class="hint">{w(canAutostart.value ? "gallery.runs" : "gallery.opens")}</p>
      <Reason id="gallery-why" text={reason === null ? null : t(reason)} />
      <ul class="gallery">
        {EXAMPLES.map((example) => (
          <Tile
            key={example.name}
            example={example}
            off={reason !== null || opening.value}
            opens={() => void opens(example)}
          />
        ))}
      </ul>
    </Card>
  );
}
