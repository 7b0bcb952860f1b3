// A logarithmic scale whose upper end follows the largest value: it rises at once, and falls after some seconds.

const DECADES = 4; // length of the scale
const LOWEST_TOP = -2; // smallest upper end, as a power of ten
const FALL_AFTER = 3000; // ms

class LogScale {
  constructor() {
    this.top = LOWEST_TOP;
    this.reached = 0; // time when the values last reached the upper decade, ms
  }

  // Include the largest of the current values.
  include(largest, now) {
    const needed = largest > 0 ? Math.max(LOWEST_TOP, Math.ceil(Math.log10(largest))) : LOWEST_TOP;
    if (needed >= this.top) [this.top, this.reached] = [needed, now];
    else if (now - this.reached > FALL_AFTER) [this.top, this.reached] = [this.top - 1, now];
  }

  get bottom() {
    return this.top - DECADES;
  }

  // Place of a value on the scale, from 0 to 1.
  share(value) {
    return value > 0 ? Math.min(Math.max((Math.log10(value) - this.bottom) / DECADES, 0), 1) : 0;
  }
}

// The largest of numbers that may be NaN; 0 if there are none.
function largestOf(numbers) {
  let largest = 0;
  for (const number of numbers) if (number > largest) largest = number;
  return largest;
}

// A power of ten as text: 0.01, 1, 10, 10 k.
function powerText(power) {
  if (power >= 6 || power < -2) return `10${superscript(power)}`;
  if (power >= 3) return `${10 ** (power - 3)} k`;
  return power >= 0 ? String(10 ** power) : (10 ** power).toFixed(-power);
}

const superscript = (number) => [...String(number)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit] ?? "⁻").join("");
