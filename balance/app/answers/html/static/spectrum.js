/* Figure 2: singular values by order. */

function spectrum() {
  const target = byId("spectrum").firstElementChild;
  const W = Math.max(280, Math.min(target.clientWidth || 520, 620)), H = 300;
  const left = 48, right = 8, top = 14, bottom = 40;
  const floor = 1e-18, log = (x) => Math.log10(Math.max(x, floor));
  const lowest = Math.min(-16, ...scene.spectra.map((s) => log(s.dropped))) - 1;
  const y = (x) => top + (H - top - bottom) * log(x) / lowest;
  const step = (W - left - right) / scene.spectra.length;
  const out = [];
  out.push(`<defs><pattern id="hatch" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><path d="M0 0V6" class="rule" stroke-width="1.2"/></pattern></defs>`);
  for (let e = 0; e >= lowest; e -= 4) {
    const at = y(10 ** e);
    out.push(`<path d="M${left} ${at}H${W - right}" class="hair"/>`);
    const label = e === 0 ? "1" : `10<tspan dy="-5" font-size="10">−${-e}</tspan>`;
    out.push(`<text x="${left - 8}" y="${at + 4}" text-anchor="end">${label}</text>`);
  }
  scene.spectra.forEach((s, k) => {
    const x = left + k * step, middle = x + step / 2, half = Math.min(0.36 * step, 40);
    const edge = y(s.dropped), base = H - bottom;
    const box = (from, to, fill) => `<rect x="${middle - half}" y="${from}" width="${2 * half}" height="${Math.max(to - from, 0)}" ${fill}/>`;
    out.push(box(y(s.kept), edge, 'class="band"'), box(edge, base, 'fill="url(#hatch)"'));
    out.push(`<path d="M${middle - half} ${edge}h${2 * half}" class="edge"/>`);
    for (const value of s.values) {
      const at = y(value);
      out.push(`<path d="M${middle - 0.8 * half} ${at}h${1.6 * half}" class="value"/>`);
    }
    out.push(`<text x="${middle}" y="${base + 16}" text-anchor="middle">${s.order}</text>`);
  });
  const last = scene.spectra[scene.spectra.length - 1];
  out.push(`<path d="M${left} ${top}V${H - bottom}H${W - right}" class="frame"/>`);
  out.push(`<text x="${left + (W - left - right) / 2}" y="${H - 6}" text-anchor="middle">order of derivative</text>`);
  const label = `Singular values by order; at order ${last.order} ${last.gap}`;
  target.innerHTML = `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="${label}">${out.join("")}</svg>`;
}
