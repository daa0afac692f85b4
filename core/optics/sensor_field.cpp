#include "core/optics/sensor_field.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/optics/hologram.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {
namespace {

constexpr int kTilePx = 64;  // of the SLM outside the subapertures

const std::vector<std::complex<float>>& phasors() {
  static const auto table = [] {
    std::vector<std::complex<float>> made(65536);
    for (std::size_t k = 0; k < made.size(); ++k) {
      made[k] = std::complex<float>(std::polar(1.0, 2.0 * std::numbers::pi * double(k) / 65536.0));
    }
    return made;
  }();
  return table;
}

/// Waves to the nearest 1/65536, whole waves overflow away: the low bits of a double of 1.5 * 2^52.
std::uint16_t phase16(double waves) {
  constexpr double kRounder = 6755399441055744.0;
  return std::uint16_t(std::bit_cast<std::uint64_t>(waves * 65536.0 + kRounder));
}

/// The number of each SLM pixel's subaperture, -1 outside; the same circles as the hologram's.
Image<int> owners(const Lattice& lattice, Vec2 pupil, const SlmGeometry& slm) {
  Image<int> owner(slm.width_px, slm.height_px, -1);
  const double radius = 0.5 * lattice.diameter_px;
  for (std::size_t i = 0; i < lattice.subapertures.size(); ++i) {
    const Vec2 c = pupil + lattice.subapertures[i].centre_px;
    const int last = std::min(slm.height_px - 1, int(std::floor(c.y + radius)));
    for (int y = std::max(0, int(std::ceil(c.y - radius))); y <= last; ++y) {
      const double half = std::sqrt(std::max(0.0, radius * radius - (y - c.y) * (y - c.y)));
      const int begin = std::max(0, int(std::ceil(c.x - half)));
      const int end = std::min(slm.width_px, int(std::floor(c.x + half)) + 1);
      if (begin < end) std::fill_n(owner.row(y) + begin, end - begin, int(i));
    }
  }
  return owner;
}

}  // namespace

Result<SensorField> SensorField::make(const SensorConfig& sensor, const SlmGeometry& slm,
                                      const OpticsConfig& optics, int cols, int rows) {
  HologramConfig hologram;
  hologram.slm = slm;
  hologram.sensor = sensor;
  const auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  SensorField field(slm, far_field_window(sensor, slm, optics, cols, rows));
  field.pupil_centre_px_ = {0.5 * (slm.width_px - 1), 0.5 * (slm.height_px - 1)};
  field.pupil_radius_px_ = 0.5 * sensor.pupil_diameter_px;
  field.cut(renderer->lattice(), slm);
  renderer->render(HologramKind::sensor, {}, field.grey_);
  field.pupil_ = Image<std::complex<float>>(slm.width_px, slm.height_px);
  return field;
}

void SensorField::cut(const Lattice& lattice, const SlmGeometry& slm) {
  subapertures_ = int(lattice.subapertures.size());
  for (const Subaperture& s : lattice.subapertures) {
    pieces_.push_back({s.centre_px, 0.5 * lattice.diameter_px, s.frequency_cpp});
  }
  const int across = (slm.width_px + kTilePx - 1) / kTilePx;
  const int down = (slm.height_px + kTilePx - 1) / kTilePx;
  for (int k = 0; k < across * down; ++k) {
    const double half = 0.5 * (kTilePx - 1);
    const int left = k % across * kTilePx, top = k / across * kTilePx;
    const Vec2 corner{double(left), double(top)};
    pieces_.push_back({corner + Vec2{half, half} - pupil_centre_px_, std::sqrt(2.0) * half, {}});
  }
  Image<int> owner = owners(lattice, pupil_centre_px_, slm);
  for (int y = 0; y < slm.height_px; ++y) {
    for (int x = 0; x < slm.width_px; ++x) {
      int& piece = owner.at(x, y);
      if (piece < 0) piece = subapertures_ + y / kTilePx * across + x / kTilePx;
      if (x == 0 || piece != runs_.back().piece) runs_.push_back({piece, y, x, x});
      runs_.back().end = x + 1;
    }
  }
  std::stable_sort(runs_.begin(), runs_.end(),
                   [](const Run& a, const Run& b) { return a.piece < b.piece; });
}

void SensorField::propagate(std::span<const Mode> modes, std::span<const double> amplitudes) {
  const std::vector<std::complex<float>>& table = phasors();
  const WavefrontRows added(modes, pupil_centre_px_, 2.0 * pupil_radius_px_);
  std::vector<double> waves(pupil_.width);
  if (!outside_lit_) std::fill(pupil_.pixels.begin(), pupil_.pixels.end(), 0.0F);
  const auto fill = [&](int y, int begin, int end, float amplitude) {
    const std::span<double> phase(waves.data(), std::size_t(end - begin));
    added.waves(y, begin, phase);
    const std::uint8_t* grey = grey_.row(y) + begin;
    std::complex<float>* out = pupil_.row(y) + begin;
    for (std::size_t x = 0; x < phase.size(); ++x) {
      out[x] = amplitude * table[std::uint16_t((grey[x] << 8) + phase16(phase[x]))];
    }
  };
  for (int y = 0; outside_lit_ && y < pupil_.height; ++y) fill(y, 0, pupil_.width, 1.0F);
  for (const Run& run : runs_) {
    if (run.piece >= subapertures_ || (outside_lit_ && amplitudes.empty())) break;
    fill(run.y, run.begin, run.end, amplitudes.empty() ? 1.0F : float(amplitudes[run.piece]));
  }
  far_field_.propagate(pupil_, far_);
}

}  // namespace ovws
