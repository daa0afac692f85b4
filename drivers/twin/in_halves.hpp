/// Work on two threads.
#pragma once

#include <thread>

#include "core/optics/far_field.hpp"

namespace ovws::twin {

/// Runs work(first, end, worker) on the two halves of the range 0 .. count - 1 in parallel.
template <class Work>
void in_halves(int count, const Work& work) {
  const std::jthread helper([&] { work(count / 2, count, 1); });
  work(0, count / 2, 0);
}

/// FarField::propagate on two threads. `far_field` must have two workers, `out` its window's size.
inline void propagate_in_halves(FarField& far_field, const Image<std::complex<float>>& field,
                                Image<std::complex<float>>& out) {
  in_halves(field.height, [&](int first, int end, int worker) {
    far_field.transform_rows(field, first, end, worker);
  });
  in_halves(out.width, [&](int first, int end, int worker) {
    far_field.transform_columns(first, end, worker, out);
  });
}

}  // namespace ovws::twin
