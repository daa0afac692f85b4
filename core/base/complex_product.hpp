/// Complex product without the NaN and infinity checks that make std::complex multiplication slow.
#pragma once

#include <complex>

namespace ovws {

template <class T>
std::complex<T> product(std::complex<T> a, std::complex<T> b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

}  // namespace ovws
