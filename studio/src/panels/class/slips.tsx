// Slips for pupils, as a page to print: name, code, address, and a QR code that fills in the
// sign-in form.
import { signal, useSignal } from "@preact/signals";
import { correction, generate } from "lean-qr";
import { toSvgDataURL } from "lean-qr/extras/svg";
import { Button, TextField } from "../../ui/parts";
import type { Roll } from "./roll";
import { w } from "./words";

/** Pupils whose slips are shown; null if hidden. */
export const slips = signal<Roll["pupils"] | null>(null);

/**
 * Address on a slip, also in its QR code. The code is behind `#`, which browsers do not send to
 * servers.
 */
const addressOf = (place: string, name: string, code: string): string =>
  `${place}/#/class?${new URLSearchParams({ name, code })}`;

const qrCodeOf = (text: string): string =>
  toSvgDataURL(generate(text, { minCorrectionLevel: correction.M }), { on: "#000", off: "#fff" });

const isLocal = (place: string): boolean => /^https?:\/\/(localhost|127\.|\[::1\])/.test(place);

export function Slips() {
  const place = useSignal(location.origin);
  const base = place.value.trim().replace(/\/+$/, "");
  const pupils = slips.value ?? [];
  return (
    <section class="arms slips-page">
      <div class="slips-bar">
        <TextField
          id="slips-address"
          label={w("slips.address")}
          value={place.value}
          inputMode="url"
          live
          set={(text) => (place.value = text)}
          hint={w(isLocal(base) ? "slips.here" : "slips.hint")}
          bad={isLocal(base)}
        />
        <div class="buttons-row">
          <Button id="slips-print" class="primary" text={w("slips.print")} press={() => print()} />
          <Button id="slips-back" text={w("slips.back")} press={() => (slips.value = null)} />
        </div>
      </div>
      <ul class="slips">
        {pupils.map(({ name, code }) => (
          <li key={name} data-testid={`slip-${name}`}>
            <a href={addressOf(base, name, code ?? "")} target="_blank" rel="noreferrer">
              <img alt={w("slips.qr", { name })} src={qrCodeOf(addressOf(base, name, code ?? ""))} />
            </a>
            <p class="slip-name">{name}</p>
            <p class="slip-code">{code}</p>
            <p class="slip-address">{base}</p>
          </li>
        ))}
      </ul>
    </section>
  );
}
