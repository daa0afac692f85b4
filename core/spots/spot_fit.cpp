#include "core/spots/spot_fit.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/pixels.hpp"
#include "core/spots/spot_sums.hpp"

namespace ovws {
namespace {

constexpr double kMinSignal = 5.0;  // smallest level of a spot, in standard errors

/// Binned pixels of a window, minus `offset` per pixel (the value of its first pixel). Without the
/// offset, a small spot on a high background would lose digits in the sums.
struct Loaded {
  float offset = 0.0F;
  float brightest = 0.0F;
};

template <class T>
Loaded load_from(const PixelRows<T>& pixels, const SpotWindow& window, float* cells) {
  const auto offset = float(pixels.first[0]);
  return {offset, float(bin_cells(pixels, window.side, window.bin, offset, cells))};
}

Loaded load_cells(const ImageView& whole, const SpotWindow& window, SpotFit::Scratch& scratch) {
  const ImageView image = seen_by(window, whole);
  if (in_place(image)) {
    const std::ptrdiff_t bytes = image.stride_bytes;
    if (bytes_in_place(image) == 1) {
      return load_from<std::uint8_t>({image.row<std::uint8_t>(window.top) + window.left, bytes},
                                     window, scratch.cells.data());
    }
    return load_from<std::uint16_t>({image.row<std::uint16_t>(window.top) + window.left, bytes / 2},
                                    window, scratch.cells.data());
  }
  const int left = window.left / window.plane_step(), top = window.top / window.plane_step();
  const int count = window.side * window.bin;
  std::uint16_t* const copy = scratch.pixels.data();
  visit_rows(image, left, top, count, count, [&](int x, int y, const auto* pixels, int run) {
    std::copy_n(pixels, run, copy + std::ptrdiff_t(y - top) * count + x - left);
  });
  return load_from<std::uint16_t>({copy, count}, window, scratch.cells.data());
}

float square_sum(std::span<const float> values) {
  float sum = 0.0F;
  for (const float v : values) sum += v * v;
  return sum;
}

}  // namespace

double excess_intensity(const SpotTemplates& spot, const SpotEstimates& found) {
  const double cell_level = double(found.level) * spot.window.bin * spot.window.bin;
  const double light = cell_level * spot.intensity_norm;
  const double free = spot.used - 2 - spot.estimates();
  return free * (double(found.chi2_per_cell) - 1.0) / (light * light);
}

double excess_scatter_of(const SpotTemplates& spot, double level_dn) {
  const double light = level_dn * spot.window.bin * spot.window.bin * spot.intensity_norm;
  return std::sqrt(2.0 * spot.lit) / (light * light);
}

SpotFit::Scratch SpotFit::make_scratch() const {
  std::size_t pixels = 0, cells = 0, sums = 0;
  for (const SpotTemplates& spot : spots_) {
    const auto count = std::size_t(spot.window.side * spot.window.bin);
    pixels = std::max(pixels, count * count);
    cells = std::max(cells, std::size_t(padded(spot.window.cells())));
    sums = std::max(sums, std::size_t(spot.rows.rows()));
  }
  return {std::vector<std::uint16_t>(pixels), std::vector<float>(cells, 0.0F),
          std::vector<float>(sums, 0.0F)};
}

SpotEstimates SpotFit::fit(const ImageView& image, std::size_t number, Scratch& scratch) const {
  const SpotTemplates& spot = spots_[number];
  SpotEstimates found;
  const int rows = int(spot.rows.rows()), count = spot.estimates();
  if (rows == 0) return found;
  const Loaded loaded = load_cells(image, spot.window, scratch);
  float* const sums = scratch.sums.data();
  const float squares = dot_rows(spot.rows.data(), rows, spot.weights.data(), scratch.cells.data(),
                                 int(spot.rows.cols()), sums);
  const float explained = square_sum({sums, SpotTemplates::kX}) +
                          square_sum({sums + SpotTemplates::kFixed, std::size_t(count)});
  const double background = double(sums[SpotTemplates::kBackground]) / spot.even_norm;
  const double level =
      (double(sums[SpotTemplates::kLevel]) - background * spot.overlap) / spot.intensity_norm;
  const double pixels = spot.window.bin * spot.window.bin;
  found.peak = loaded.brightest;
  found.chi2_per_cell = (squares - explained) / float(spot.used - 2 - count);
  found.background = loaded.offset + float(background / pixels);
  if (!(level * spot.intensity_norm > kMinSignal)) return found;
  found.level = float(level / pixels);
  found.x = float(spot.place_px.x + double(sums[SpotTemplates::kX]) / level);
  found.y = float(spot.place_px.y + double(sums[SpotTemplates::kY]) / level);
  for (int k = 0; k < count; ++k) {
    found.values[std::size_t(k)] = float(double(sums[SpotTemplates::kFixed + k]) / level);
  }
  return found;
}

}  // namespace ovws
