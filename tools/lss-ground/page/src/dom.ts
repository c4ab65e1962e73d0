// Small helpers around the document.

export function $(id: string): HTMLElement {
  return document.getElementById(id)!;
}

type Child = Node | string | null | undefined | false;

export function el(tag: string, attributes: Record<string, string | boolean> = {}, ...children: Child[]): HTMLElement {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false) continue;
    element.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children) if (child) element.append(child);
  return element;
}

// Replaces the children only when their data has changed, so that nothing flickers under the pointer or loses the
// focus.
const shown = new WeakMap<Element, string>();
export function show(where: Element, from: unknown, make: () => Child[]) {
  const key = JSON.stringify(from);
  if (shown.get(where) === key) return;
  shown.set(where, key);
  where.replaceChildren(...make().filter((c): c is Node | string => Boolean(c)));
}

export function age(ms: number | null | undefined): string {
  if (ms === null || ms === undefined || ms < 0) return "never";
  if (ms < 1000) return `${Math.round(ms)} ms`;
  if (ms < 60_000) return `${(ms / 1000).toFixed(1)} s`;
  return `${Math.round(ms / 60_000)} min`;
}

// The name of the commanding source; for a page, enough characters to distinguish it.
export function sourceName(source: string): string {
  return source.replace(/^(ground:[0-9a-f]{8})[0-9a-f]+$/, "$1…");
}

export function fixed(value: unknown, digits: number): string {
  return typeof value === "number" && Number.isFinite(value) ? value.toFixed(digits) : "–";
}

// The daemon's advice names commands of the command line; the page has buttons of the same names.
export function advice(text: string): string {
  return text.replace(/lss-cli ([a-z][a-z-]*)/g, "“$1”");
}

export const kDegree = Math.PI / 180;
