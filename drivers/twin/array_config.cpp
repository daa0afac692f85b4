#include "drivers/twin/array_config.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "proto/tables/sensor.hpp"

namespace ovws::twin {
namespace {

constexpr int kMaxAcross = 128, kMinReachPx = 4, kMaxReachPx = 256;
constexpr int kMinSamples = 32, kMaxSamples = 144, kSamplesStep = 8;

void read_optional(ObjectReader& r, const char* key, std::optional<double>& out) {
  if (!r.has(key)) return;
  out.reset();
  if (r.is_null(key)) return;
  r.number(key, out.emplace(), 0.01, 1000.0);
}

void read_shape(ObjectReader& r, std::optional<LensletShape>& out) {
  if (!r.has("shape")) return;
  out.reset();
  if (r.is_null("shape")) return;
  int shape = 0;
  r.choice("shape", shape, kNames<LensletShape>());
  out = LensletShape(shape);
}

void read_plate(ObjectReader& r, PlateConfig& plate) {
  r.integer("levels", plate.levels, 0, 1024);
  r.number("depth", plate.depth, -4.0, 4.0);
  std::vector<double> shift{plate.shift_um.x, plate.shift_um.y};
  r.numbers("shift_um", shift, 2, 2, -1000.0, 1000.0);
  plate.shift_um = {shift[0], shift[1]};
}

/// Samples that a cell needs so that the next diffraction order of the samples, which is as many
/// lambda/d away, falls outside three times the reach.
int wanted_samples(const ArrayConfig& array, const OpticsConfig& optics) {
  const double lambda_d_um =
      1e-3 * optics.wavelength_nm * 1e3 * optics.focal_length_mm / array.pitch_um;
  const double wanted = 3.3 * array.reach_pitches * array.pitch_um / lambda_d_um;
  return int(std::min(1e6, kSamplesStep * std::ceil(wanted / kSamplesStep)));
}

}  // namespace

LensletShape shape_of(const ArrayConfig& array) {
  return array.shape.value_or(filling_shape(array.lattice));
}

double row_um(const ArrayConfig& array) {
  return array.lattice == Grid::square ? array.pitch_um
                                       : array.pitch_um * std::numbers::sqrt3 / 2.0;
}

double pupil_um(const ArrayConfig& array) {
  if (array.pupil_mm) return 1e3 * *array.pupil_mm;
  return std::min(array.columns * array.pitch_um, array.rows * row_um(array));
}

int reach_px(const ArrayConfig& array, double px_per_um) {
  const double reach = std::ceil(array.reach_pitches * array.pitch_um * px_per_um);
  return int(std::clamp(reach, double(kMinReachPx), double(kMaxReachPx)));
}

int samples_across(const ArrayConfig& array, const OpticsConfig& optics) {
  return std::clamp(wanted_samples(array, optics), kMinSamples, kMaxSamples);
}

void read_array(ObjectReader& r, ArrayConfig& array) {
  r.number("pitch_um", array.pitch_um, 5.0, 10e3);
  int lattice = int(array.lattice);
  r.choice("lattice", lattice, kNames<Grid>());
  array.lattice = Grid(lattice);
  read_shape(r, array.shape);
  r.integer("columns", array.columns, 1, kMaxAcross);
  r.integer("rows", array.rows, 1, kMaxAcross);
  read_optional(r, "pupil_mm", array.pupil_mm);
  read_optional(r, "beam_diameter_mm", array.beam_diameter_mm);
  r.object("plate", [&array](ObjectReader& in) { read_plate(in, array.plate); });
  r.number("reach_pitches", array.reach_pitches, 0.5, 4.0);
}

Result<void> check_array(const ArrayConfig& array, const OpticsConfig& optics,
                         double magnification) {
  if (!fits_into(array.lattice, shape_of(array))) {
    return fail(Errc::invalid, "array.shape",
                "squares fill a square lattice and hexagons a hexagonal one: set null, \"circle\", "
                "or another array.lattice");
  }
  const double reach =
      array.reach_pitches * array.pitch_um * magnification / optics.camera_pitch_um;
  if (reach > kMaxReachPx || reach < kMinReachPx) {
    return fail(Errc::invalid, "array.reach_pitches",
                "the field of a lenslet reaches " + std::to_string(int(reach)) +
                    " camera pixels from its centre, but must reach " +
                    std::to_string(kMinReachPx) + " to " + std::to_string(kMaxReachPx) +
                    ": change it, array.pitch_um or optics.magnification");
  }
  if (wanted_samples(array, optics) > kMaxSamples) {
    return fail(Errc::invalid, "optics.focal_length_mm",
                "too short for the twin: the light of a lenslet needs more than " +
                    std::to_string(kMaxSamples) +
                    " samples across; lower array.reach_pitches or array.pitch_um");
  }
  return {};
}

}  // namespace ovws::twin
