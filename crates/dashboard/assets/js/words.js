// The 32-bit words and the positions, taken apart.

/** The fields of a word from the highest bit down: name, highest bit, lowest bit. */
export const FIELDS = [
  ["service_bit", 31, 31],
  ["read_write", 30, 30],
  ["error", 29, 29],
  ["reserve", 28, 28],
  ["service", 27, 24],
  ["data", 23, 0],
];

export const bits = (text) => (text == null ? 0 : Number.parseInt(text, 16) >>> 0);
export const bit31 = (text) => bits(text) >>> 31;

/** The value of a field in a word. */
export function field(word, [, high, low]) {
  const width = high - low + 1;
  return (word >>> low) & (width === 32 ? 0xffffffff : 2 ** width - 1);
}

/** Whether the master looks for a fault: then no data come, whatever the segments do. */
export function searches({ diagnosis: { status } }) {
  return status != null && (Number.parseInt(status, 16) & 0x10) !== 0;
}

export const hex = (value, digits) => value.toString(16).toUpperCase().padStart(digits, "0");
export const binary = (value, digits = 24) => value.toString(2).padStart(digits, "0").replace(/(.{4})(?=.)/g, "$1 ");
export const gray = (value) => (value ^ (value >>> 1)) >>> 0;

/** The OUT word of a service. */
export function request(service, writes, data, bit) {
  return ((bit ? 0x80000000 : 0) | (writes ? 0x40000000 : 0) | (service << 24) | (data & 0xffffff)) >>> 0;
}

/** A value as people write it: decimal, or hexadecimal with 0x or h. */
export function value(text) {
  const written = text.trim();
  const digits = /^0x([0-9a-f]+)$/i.exec(written)?.[1] ?? /^([0-9][0-9a-f]*)h$/i.exec(written)?.[1];
  if (digits) return Number.parseInt(digits, 16);
  return /^[0-9]+$/.test(written) ? Number(written) : NaN;
}

/** What an active parameter is; undefined where it is not known, or the model has none. */
export function active(device, service) {
  const known = device.parameters?.find((parameter) => parameter.service === service)?.active;
  // Of an encoder that is only looked at it stands with how it is known.
  return known?.value ?? (typeof known === "number" ? known : undefined);
}

/** The turns of every shaft, where the model has no numerator. */
const SENSOR_TURNS = 4096;

/** The position in degrees and turns, or in millimetres. */
export function place(device, unit) {
  const length = active(device, 2);
  if (device.value == null || length == null) return null;
  if (unit.kind === "linear") return unit.rod_um == null ? null : { mm: (device.value * unit.rod_um) / 1000 / length };
  const has = (service) => unit.services.some(({ number }) => number === service);
  const [numerator, denominator] = [[3, SENSOR_TURNS], [9, 1]].map(([service, lacking]) => (has(service) ? active(device, service) : lacking));
  if (numerator == null || denominator == null) return null;
  const turns = numerator / denominator;
  const all = (device.value * turns) / (length + 1);
  return { turns: Math.floor(all), degrees: (all % 1) * 360 };
}
