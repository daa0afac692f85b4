#include "core/optics/sensor_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/optics/circle_columns.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/phase_rows.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {
namespace {

constexpr double kMaxLogarithm = 2.0;  // of amplitudes: polynomials grow outside the pupil
constexpr int kTilePx = 64;            // side of the pieces outside the subapertures

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

constexpr int kFixed = -2;    // outside the pupil: modes are not applied
constexpr int kUnowned = -1;  // in the pupil, outside the subapertures

void assign_owner(Image<int>& owner, Vec2 centre_px, double diameter_px, int to) {
  for (int y = 0; y < owner.height; ++y) {
    const Columns in = columns_in_circle(centre_px, diameter_px, y, owner.width);
    std::fill_n(owner.row(y) + in.begin, in.end - in.begin, to);
  }
}

}  // namespace

Result<SensorField> SensorField::make(const SensorConfig& sensor, const SlmGeometry& slm,
                                      const OpticsConfig& optics, int cols, int rows) {
  if (auto straight = check_straight(optics, slm); !straight) return fail(straight.error());
  HologramConfig hologram;
  hologram.slm = slm;
  hologram.sensor = sensor;
  const auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  SensorField field(slm, far_field_window(sensor, slm, optics, cols, rows));
  field.pupil_centre_px_ = {0.5 * (slm.width_px - 1), 0.5 * (slm.height_px - 1)};
  field.pupil_radius_px_ = 0.5 * sensor.pupil_diameter_px;
  field.split_into_pieces(renderer->lattice(), slm);
  renderer->render(HologramKind::sensor, {}, field.grey_);
  field.pupil_ = Image<std::complex<float>>(slm.width_px, slm.height_px);
  return field;
}

void SensorField::split_into_pieces(const Lattice& lattice, const SlmGeometry& slm) {
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
  Image<int> owner(slm.width_px, slm.height_px, kFixed);
  assign_owner(owner, pupil_centre_px_, 2.0 * pupil_radius_px_, kUnowned);
  for (int i = 0; i < subapertures_; ++i) {
    assign_owner(owner, pupil_centre_px_ + pieces_[i].centre_px, 2.0 * pieces_[i].radius_px, i);
  }
  for (int y = 0; y < slm.height_px; ++y) {
    int last = kFixed;
    for (int x = 0; x < slm.width_px; ++x) {
      int piece = owner.at(x, y);
      if (piece == kUnowned) piece = subapertures_ + y / kTilePx * across + x / kTilePx;
      if (piece != kFixed && piece != last) runs_.push_back({piece, y, x, x});
      if (piece != kFixed) runs_.back().end = x + 1;
      last = piece;
    }
  }
  std::stable_sort(runs_.begin(), runs_.end(),
                   [](const Run& a, const Run& b) { return a.piece < b.piece; });
}

void SensorField::propagate(std::span<const Mode> modes, const Light& light) {
  const std::vector<std::complex<float>>& table = phasors();
  const WavefrontRows added(modes, pupil_centre_px_, 2.0 * pupil_radius_px_);
  const WavefrontRows logarithm(light.ln_amplitude, pupil_centre_px_, 2.0 * pupil_radius_px_);
  const std::span<const Vec2> slopes_cpp = light.slopes_cpp;
  const std::span<const double> amplitudes = light.amplitudes;
  std::vector<double> waves(pupil_.width), ln(pupil_.width);
  if (!outside_lit_) std::fill(pupil_.pixels.begin(), pupil_.pixels.end(), 0.0F);
  const auto attenuate = [&](int y, int begin, int end) {
    if (light.ln_amplitude.empty()) return;
    const std::span<double> factor(ln.data(), std::size_t(end - begin));
    logarithm.waves(y, begin, factor);
    std::complex<float>* out = pupil_.row(y) + begin;
    for (std::size_t x = 0; x < factor.size(); ++x) {
      out[x] *= float(std::exp(std::min(factor[x], kMaxLogarithm)));
    }
  };
  const auto fill_fixed = [&](int y, int begin, int end) {
    for (int x = begin; x < end; ++x) pupil_.at(x, y) = table[std::size_t(grey_.at(x, y)) << 8];
    attenuate(y, begin, end);
  };
  const auto fill = [&](int y, int begin, int end, float amplitude, int piece) {
    const std::span<double> phase(waves.data(), std::size_t(end - begin));
    added.waves(y, begin, phase);
    if (piece >= 0 && !slopes_cpp.empty()) {
      const Vec2 slope = slopes_cpp[std::size_t(piece)];
      const Vec2 centre = pupil_centre_px_ + pieces_[std::size_t(piece)].centre_px;
      for (std::size_t x = 0; x < phase.size(); ++x) {
        phase[x] += slope.x * (begin + double(x) - centre.x) + slope.y * (y - centre.y);
      }
    }
    const std::uint8_t* grey = grey_.row(y) + begin;
    std::complex<float>* out = pupil_.row(y) + begin;
    for (std::size_t x = 0; x < phase.size(); ++x) {
      out[x] = amplitude * table[std::uint16_t((grey[x] << 8) + phase16(phase[x]))];
    }
    attenuate(y, begin, end);
  };
  for (int y = 0; outside_lit_ && y < pupil_.height; ++y) {
    const Columns in = columns_in_circle(pupil_centre_px_, 2.0 * pupil_radius_px_, y, pupil_.width);
    fill_fixed(y, 0, in.begin);
    fill(y, in.begin, in.end, 1.0F, -1);
    fill_fixed(y, in.end, pupil_.width);
  }
  for (const Run& run : runs_) {
    if (run.piece >= subapertures_) break;
    if (outside_lit_ && amplitudes.empty() && slopes_cpp.empty()) break;
    const float amplitude = amplitudes.empty() ? 1.0F : float(amplitudes[run.piece]);
    fill(run.y, run.begin, run.end, amplitude, run.piece);
  }
  far_field_.propagate(pupil_, far_);
}

}  // namespace ovws
