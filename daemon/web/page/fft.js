// Fast Fourier transform of complex numbers, radix 2, in place.

/** Plan for lines of `length` complex numbers, a power of two: the order of bit reversal and the twiddle factors. */
function plan(length) {
  const bits = Math.log2(length);
  const reversed = new Uint32Array(length);
  for (let i = 0; i < length; ++i) for (let b = 0; b < bits; ++b) if (i & (1 << b)) reversed[i] |= 1 << (bits - 1 - b);
  const cosine = Float64Array.from({ length: length / 2 }, (_, k) => Math.cos((2 * Math.PI * k) / length));
  const sine = Float64Array.from({ length: length / 2 }, (_, k) => -Math.sin((2 * Math.PI * k) / length));
  return { length, reversed, cosine, sine };
}

/** Transforms the line re[first + k step] + i im[…]: X_u = sum x_k exp(-2 pi i u k / length). */
function transformLine({ length, reversed, cosine, sine }, re, im, first, step) {
  for (let i = 0; i < length; ++i) {
    const k = reversed[i];
    if (k <= i) continue;
    const [a, b] = [first + i * step, first + k * step];
    [re[a], re[b]] = [re[b], re[a]];
    [im[a], im[b]] = [im[b], im[a]];
  }
  for (let half = 1; half < length; half *= 2) {
    const stride = length / (2 * half);
    for (let block = 0; block < length; block += 2 * half) {
      for (let k = 0; k < half; ++k) {
        const a = first + (block + k) * step;
        const b = a + half * step;
        const [c, s] = [cosine[k * stride], sine[k * stride]];
        const x = re[b] * c - im[b] * s;
        const y = re[b] * s + im[b] * c;
        re[b] = re[a] - x;
        im[b] = im[a] - y;
        re[a] += x;
        im[a] += y;
      }
    }
  }
}

/** Transforms size x size complex numbers, by rows; size a power of two. */
export function fft2(re, im, size) {
  const line = plan(size);
  for (let row = 0; row < size; ++row) transformLine(line, re, im, row * size, 1);
  for (let column = 0; column < size; ++column) transformLine(line, re, im, column, size);
}
